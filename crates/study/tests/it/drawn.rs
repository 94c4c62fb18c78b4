//! Cells drawn at random are what they promise, and run like any program.

use lostmotion_sim::{Program, Simulation};
use lostmotion_study::drawn::{draw, markdown, run, run_all};

#[test]
fn cells_are_drawn_as_wide_as_promised_and_can_be_cut() {
    let mut least = [f64::INFINITY; 3];
    let mut most = [0.0_f64; 3];
    for index in 0..60 {
        let cell = draw(20_261_123, index).unwrap();
        assert_eq!(cell.name, draw(20_261_123, index).unwrap().name);
        let values = [
            cell.traits.gap_um[0],
            cell.traits.friction[0],
            cell.traits.inertia_ratio[0],
        ];
        for ((least, most), value) in least.iter_mut().zip(&mut most).zip(values) {
            *least = least.min(value);
            *most = most.max(value);
        }
        assert!((17..=24).contains(&cell.traits.encoder_bits));
        // The machine is a machine file, the program one that it can cut.
        let text = cell.machine.to_toml().unwrap();
        assert!(text.contains("gap_um"), "{text}");
        let program = Program::from_str(cell.name.clone(), cell.program.clone());
        let info = Simulation::new(&program, &cell.machine).check();
        assert!(info.is_ok(), "{}: {info:?}\n{}", cell.name, cell.program);
        // Its drives are sound: a method is to blame for what it does, not the tuning.
        for (tuning, axis) in cell.machine.tuning().iter().zip(cell.machine.axes()) {
            let fault = tuning.loops.fault(&axis.config);
            assert!(fault.is_none(), "{}: {fault:?}", cell.name);
        }
    }
    assert!(least[0] < 10.0 && most[0] > 80.0, "{least:?} {most:?}");
    assert!(least[1] == 0.0 && most[1] > 0.12, "{least:?} {most:?}");
    assert!(least[2] < 0.5 && most[2] > 2.0, "{least:?} {most:?}");
    assert_ne!(draw(1, 0).unwrap().machine, draw(2, 0).unwrap().machine);
}

#[test]
fn a_cell_runs_as_users_run_it_on_any_number_of_threads() {
    let methods = ["fixed".to_owned()];
    let [one, two] = [1, 2].map(|threads| run_all(5, 2, &methods, threads).unwrap());
    assert_eq!(one, two);
    let cell = draw(5, 1).unwrap();
    assert_eq!(run(&cell, &methods).unwrap(), one[1]);
    let program = Program::from_str(cell.name.clone(), cell.program.clone());
    let direct = Simulation::new(&program, &cell.machine)
        .methods(["none", "fixed"])
        .run()
        .unwrap();
    assert_eq!(
        direct.results[1].backlash.rms,
        one[1].methods[1].whole.backlash_rms
    );
    // The halves add up: the larger maximum of both is at least that of the second.
    let figures = &one[1].methods[1];
    assert!(figures.second_half.contour_max <= figures.whole.contour_max);
    assert!(figures.second_half.contour_rms > 0.0);
    let table = markdown(&one, "drawn with seed 5");
    assert!(
        table.contains(&one[0].name) && table.contains("| `fixed` |"),
        "{table}"
    );
}
