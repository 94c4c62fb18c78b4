//! Which function carries out a code.

use super::{
    Exec, arc, compensation, context, curves, cycles, five_axis, haas, modes, offsets, outputs,
    spindle, stop, straight, thread, tool, turning,
};
use crate::code::Code;
use crate::problem::Problem;

/// Carries a code out.
pub(crate) type Action = fn(&mut Exec<'_>, Code) -> Result<(), Problem>;

/// The function of a code; `None` if there is none.
pub(crate) fn action(code: Code) -> Option<Action> {
    Some(match (code.letter, code.tenths) {
        ('G', 0) => straight::traverse,
        ('G', 10) => straight::feed,
        ('G', 20 | 30) => arc::arc,
        ('G', 40) => straight::dwell,
        ('G', 50) => curves::cubic,
        ('G', 51) => curves::quadratic,
        ('G', 52) => curves::nurbs,
        ('G', 53) => curves::nurbs_end,
        ('G', 70 | 80) => modes::diameter,
        ('G', 100) => offsets::g10,
        ('G', 120 | 130) => haas::pocket,
        ('G', 170 | 180 | 190) => modes::plane,
        ('G', 200 | 210) => modes::units,
        ('G', 280 | 300) => straight::go,
        ('G', 281 | 301) => straight::store,
        ('G', 330) => spindle::synchronised,
        ('G', 331) => spindle::rigid_tap,
        ('G', 382..=385) => straight::probe,
        ('G', 400) => compensation::off,
        ('G', 410 | 420) => compensation::on,
        ('G', 411 | 421) => compensation::dynamic,
        ('G', 430) => tool::length,
        ('G', 431) => tool::dynamic_length,
        ('G', 432) => tool::added_length,
        ('G', 434 | 435) => five_axis::tip,
        ('G', 490) => tool::no_length,
        ('G', 520) => offsets::local,
        ('G', 530) => straight::machine_coordinates,
        ('G', 531) => five_axis::orient,
        ('G', 540 | 550 | 560 | 570 | 580 | 590 | 591 | 592 | 593) => offsets::select,
        ('G', 610) => modes::exact_path,
        ('G', 611) => modes::exact_stop,
        ('G', 640) => modes::continuous,
        ('G', 680) => five_axis::rotate,
        ('G', 682) => five_axis::tilt,
        ('G', 690) => five_axis::untilt,
        ('G', 700 | 710 | 711 | 712 | 720 | 721 | 722) => turning::cycle,
        ('G', 730 | 740 | 810 | 820 | 830 | 840 | 850 | 860 | 870 | 880 | 890) => cycles::cycle,
        ('G', 760) => thread::thread,
        ('G', 800) => modes::no_motion,
        ('G', 900 | 910) => modes::distance,
        ('G', 901 | 911) => modes::arc_distance,
        ('G', 920) => offsets::g92,
        ('G', 921) => offsets::g92_forget,
        ('G', 922) => offsets::g92_suspend,
        ('G', 923) => offsets::g92_restore,
        ('G', 930 | 940 | 950) => modes::feed_mode,
        ('G', 960) => spindle::surface_speed,
        ('G', 970) => spindle::constant_speed,
        ('G', 980 | 990) => cycles::retract,
        ('M', 0) => stop::stop,
        ('M', 10) => stop::optional_stop,
        ('M', 20 | 300) => stop::end,
        ('M', 30 | 40) => spindle::spindle_on,
        ('M', 50) => spindle::spindle_off,
        ('M', 60) => tool::change,
        ('M', 70 | 80 | 90) => spindle::coolant,
        ('M', 190) => spindle::orient,
        ('M', 480 | 490) => spindle::overrides,
        ('M', 500) => spindle::feed_override,
        ('M', 510) => spindle::speed_override,
        ('M', 520) => spindle::adaptive_feed,
        ('M', 530) => spindle::feed_hold,
        ('M', 600) => stop::pallet,
        ('M', 610) => tool::set_number,
        ('M', 620 | 630 | 640 | 650) => outputs::digital,
        ('M', 660) => outputs::input,
        ('M', 670 | 680) => outputs::analog,
        ('M', 700 | 730) => context::save,
        ('M', 710) => context::forget,
        ('M', 720) => context::bring_back,
        ('M', 980) => stop::call,
        ('M', 990) => stop::back,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::action;
    use crate::code::Code;
    use crate::codes::{find, rows};

    #[test]
    fn the_codes_with_a_row_are_those_with_a_function() {
        for row in rows() {
            assert!(action(row.code).is_some(), "{} has no function", row.code);
        }
        for letter in ['G', 'M'] {
            for tenths in 0..=u16::MAX {
                let code = Code { letter, tenths };
                assert!(
                    action(code).is_none() || find(code).is_some(),
                    "{code} has no row"
                );
            }
        }
    }
}
