//! What the programs in C do not reach: the table of handles, and that an axis stepped tick by tick is
//! the library's own to the bit.

use crate::axis::*;
use crate::failure::LmStatus;
use crate::machine::*;
use crate::text::*;
use lostmotion::drive::{AxisOutput, Setpoint};
use lostmotion::methods::{MethodId, build_runner};
use lostmotion::report::csv::AxisScales;
use std::collections::HashSet;
use std::mem::MaybeUninit;
use std::ptr;

/// Under Miri, which interprets, a test takes a tenth of the rounds: of 200 handles the table still grows twice.
fn rounds(usual: usize) -> usize {
    if cfg!(miri) { usual / 10 } else { usual }
}

fn machine() -> *mut LmMachine {
    let mut machine = ptr::null_mut();
    // SAFETY: a text with its zero, and room for the handle.
    let status = unsafe { lm_machine_preset(c"vmc3-worn".as_ptr(), &mut machine) };
    assert_eq!(status, LmStatus::Ok);
    machine
}

#[test]
fn ticks_are_those_of_the_library() {
    let worn = lostmotion::Machine::preset("vmc3-worn").unwrap();
    let config = worn.drive("x").unwrap();
    let scales = AxisScales::new(
        config.unit(),
        1.0 / config.transmission.motor_rad_per_unit(),
    );
    let handle = machine();
    let methods = ["none", "fixed", "published", "adaptive"];
    // The border is the same for all of them.
    let methods = &methods[..if cfg!(miri) { 2 } else { 4 }];
    for method in methods {
        let name = std::ffi::CString::new(*method).unwrap();
        let mut axis = ptr::null_mut();
        // SAFETY: texts with their zeros, and room for the handle.
        let status =
            unsafe { lm_axis_new(handle, c"x".as_ptr(), name.as_ptr(), 0.0, false, &mut axis) };
        assert_eq!(status, LmStatus::Ok);
        let method: MethodId = method.parse().unwrap();
        let mut runner = build_runner(config, method, 0.0).unwrap();
        let mut out = AxisOutput::new(true);
        for n in 0..rounds(3000) {
            let (sin, cos) = lostmotion::base::math::sin_cos(2.5e-3 * n as f64);
            let (position, velocity, acceleration) = (5.0 * sin, 12.5 * cos, -31.25 * sin);
            let setpoint = Setpoint::moving(position, velocity, acceleration);
            runner.push(&[setpoint], &mut out).unwrap();
            let setpoint = LmSetpoint {
                position,
                velocity,
                acceleration,
                load_force: f64::NAN,
                given: LM_SETPOINT_VELOCITY | LM_SETPOINT_ACCELERATION,
            };
            let mut samples = [const { MaybeUninit::<LmAxisSample>::uninit() }; 4];
            // SAFETY: a setpoint, and room for four samples.
            let status = unsafe { lm_axis_step(axis, &setpoint, samples.as_mut_ptr().cast(), 4) };
            assert_eq!(status, LmStatus::Ok);
            for (sample, own) in samples.iter().zip(out.trace.iter().flatten()) {
                // SAFETY: the call has filled all four.
                let sample = unsafe { sample.assume_init_ref() };
                let row = scales.row(own);
                let bits = |values: [f64; 5]| values.map(f64::to_bits);
                assert_eq!(
                    bits([
                        sample.reference,
                        sample.motor,
                        sample.load,
                        sample.current_a,
                        sample.shaft_force
                    ]),
                    bits([
                        row.reference,
                        row.motor,
                        row.load,
                        row.current_a,
                        row.shaft_force
                    ]),
                    "{n}"
                );
            }
            out.clear();
        }
        assert_eq!(lm_axis_free(axis), LmStatus::Ok);
    }
    assert_eq!(lm_machine_free(handle), LmStatus::Ok);
}

#[test]
fn a_handle_never_comes_twice() {
    let mut seen = HashSet::new();
    let mut held = Vec::new();
    // Places are used again, and the table grows over several chunks.
    for round in 0..rounds(2000) {
        let text = text_of("one").unwrap();
        assert!(!text.is_null() && seen.insert(text.addr()));
        held.push(text);
        if round % 3 == 0 {
            let text = held.swap_remove(held.len() / 2);
            assert_eq!(lm_text_free(text), LmStatus::Ok);
            assert_eq!(lm_text_free(text), LmStatus::Handle);
        }
    }
    for text in held {
        assert_eq!(lm_text_free(text), LmStatus::Ok);
    }
}

#[test]
fn threads_share_and_none_waits() {
    let machine = machine();
    let address = machine.expose_provenance();
    let status = std::thread::scope(|scope| {
        let look = move || {
            let machine: *mut LmMachine = ptr::with_exposed_provenance_mut(address);
            let mut number = 0.0;
            for _ in 0..rounds(200) {
                // SAFETY: a text with its zero, and room for a number.
                let status = unsafe {
                    lm_machine_number(machine, c"axis.x.load.slide.gap_um".as_ptr(), &mut number)
                };
                assert_eq!((status, number), (LmStatus::Ok, 40.0));
            }
        };
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(look)).collect();
        threads.into_iter().all(|thread| thread.join().is_ok())
    });
    assert!(status);
    assert_eq!(lm_machine_free(machine), LmStatus::Ok);
    assert_eq!(lm_machine_free(machine), LmStatus::Handle);
}

#[test]
fn a_panic_stays_inside() {
    let status = crate::border::call(|| {
        panic!("a fault");
    });
    assert_eq!(status, LmStatus::Internal);
    let told = crate::failure::with_last(|kept| kept.message.clone());
    assert_eq!(told.unwrap().to_str(), Ok("a fault"));
}
