//! Which of the methods compared to use.
//!
//! A recommendation is followed on a machine whose gap, friction and stiffness nobody knows to the
//! last digit. So every method runs as it stands and once more for each quantity that it is told,
//! or remembers, told too small and too large ([`Misled`]). The worst of these runs counts:
//!
//! 1. Out is a method that needs what the drive or the control does not have, and one that in any
//!    of its runs stops the machine, or leaves a larger RMS or a larger peak of the contour error
//!    than no compensation.
//! 2. Of the others, those that keep the tolerance in all their runs go first; among equals the
//!    smaller worst RMS decides, then the smaller worst peak.
//! 3. A method that has to be told neither gap nor load goes before one that is hardly better.

use crate::method::Choice;
use crate::results::{ErrorStats, HARM_UM, MethodResult, MisledResult, Run, Trust};
use crate::setup::Setup;
use lostmotion_base::units::number;
use lostmotion_methods::{Misled, Told, USUAL_SHARE};

/// How near a method that is told nothing has to be to the best, as part of what no compensation
/// leaves. A choice: measuring a gap costs more than a twentieth of the error is worth.
const NEAR_BEST_SHARE: f64 = 0.05;

/// The parts of what is told wrong in a comparison with which a method is tried again that is best
/// where all is told right. A choice: as many as tell a user how well to measure.
const LESS_WRONG: [f64; 3] = [0.75, 0.5, 0.25];

/// What a method is told wrong in the runs that test it: everything it is told, too small and too
/// large by a share; where it `remembers`, what it has learned, too. Methods that need a scale on the
/// load are shown, not recommended, so they are not tested.
pub(crate) fn misled_runs(
    choices: &[Choice],
    share: Option<f64>,
    remembers: bool,
) -> Vec<(usize, Misled)> {
    // One method alone is not compared with anything.
    let share = share.unwrap_or(if choices.len() < 2 { 0.0 } else { USUAL_SHARE });
    if share <= 0.0 {
        return Vec::new();
    }
    let mut runs = Vec::new();
    for (index, choice) in choices.iter().enumerate() {
        let Choice::Registered(method) = choice else {
            continue;
        };
        if method.needs_load_scale() {
            continue;
        }
        let told = |what: &Told| method.is_told(*what) || remembers && method.learns();
        for what in Told::ALL.into_iter().filter(told) {
            for factor in [1.0 - share, 1.0 + share] {
                runs.push((index, Misled { what, factor }));
            }
        }
    }
    runs
}

/// A method as the recommendation sees it.
struct Candidate {
    index: usize,
    /// Over all its runs.
    rms: f64,
    max: f64,
    within: bool,
    told_nothing: bool,
}

/// Why the machine or its control cannot use a method.
pub(crate) fn refusal(setup: &Setup<'_>, choice: &Choice) -> Option<String> {
    let (machine, options) = (setup.machine, setup.options);
    let control = options.control.or(machine.simulate().control);
    match choice {
        _ if choice.needs_load_scale(machine.configs()) => {
            Some("needs a scale on the load, which most machines do not have".to_owned())
        }
        Choice::Registered(method) => control.and_then(|control| control.refusal(*method)),
        Choice::OfAxes | Choice::Own { .. } => None,
    }
}

/// Says of each method why it is not recommended, if there is a reason, and answers the one that
/// is.
pub(crate) fn recommend(
    results: &mut [MethodResult],
    choices: &[Choice],
    refused: impl Fn(&Choice) -> Option<String>,
    tolerance_um: f64,
) -> Option<String> {
    // Whether a method is worse than doing nothing is not known unless that was tried.
    let unknown = (!results.iter().any(MethodResult::is_baseline))
        .then(|| "not compared with none: name that among the methods, too".to_owned());
    let none = results
        .iter()
        .find(|result| result.is_baseline() && result.stop.is_none())
        .map(|result| result.cutting);
    let mut candidates = Vec::new();
    for (index, (result, choice)) in results.iter_mut().zip(choices).enumerate() {
        let reason = refused(choice)
            .or_else(|| unsafe_in(result, none))
            .or_else(|| unknown.clone());
        if reason.is_none() {
            candidates.push(candidate(index, result, choice, tolerance_um));
        }
        result.not_recommended = reason;
    }
    if results.len() < 2 {
        return None;
    }
    let best = preferred(&candidates, none)?;
    Some(results.get(best)?.method.clone())
}

/// What rules a method out, in itself or where it is told something wrong.
fn unsafe_in(result: &MethodResult, none: Option<ErrorStats>) -> Option<String> {
    stops(result).or_else(|| none.and_then(|none| worse_than(result, &none)))
}

/// Whether the control stops the machine with a method, as it stands or misled.
fn stops(result: &MethodResult) -> Option<String> {
    if result.stop.is_some() {
        return Some("the machine stops".to_owned());
    }
    let misled = result.misled.iter().find(|misled| misled.stops)?;
    Some(format!("the machine stops{}", misled.when()))
}

/// In what a method is worse than no compensation, as it stands or misled.
fn worse_than(result: &MethodResult, none: &ErrorStats) -> Option<String> {
    worse(&result.cutting, none, "").or_else(|| {
        let mut misled = result.misled.iter();
        misled.find_map(|misled| worse(&misled.cutting, none, &misled.when()))
    })
}

/// In what an error is worse than that without compensation, and when.
pub(crate) fn worse(with: &ErrorStats, none: &ErrorStats, when: &str) -> Option<String> {
    let kinds = [("RMS", with.rms, none.rms), ("max", with.max, none.max)];
    kinds.into_iter().find_map(|(kind, with, without)| {
        (with.is_nan() || with > without + HARM_UM).then(|| {
            format!(
                "worse than none{when}: contour error {kind} {with:.2} um against {without:.2} um"
            )
        })
    })
}

/// Why a method is out whose gap is known in another way: as in a comparison, without the runs in which it
/// is told the gap wrong.
pub(crate) fn unsafe_but_for_gap(result: &MethodResult, none: &ErrorStats) -> Option<String> {
    let misled = result.misled.iter();
    let others = misled.filter(|run| run.misled.what != Told::Gap);
    let result = MethodResult {
        misled: others.copied().collect(),
        ..result.clone()
    };
    unsafe_in(&result, Some(*none))
}

fn candidate(index: usize, result: &MethodResult, choice: &Choice, tolerance_um: f64) -> Candidate {
    let all = || std::iter::once(&result.cutting).chain(result.misled.iter().map(|m| &m.cutting));
    let max = all().map(|cutting| cutting.max).fold(0.0, f64::max);
    let told_nothing = match choice {
        Choice::Registered(method) => !method.told_gap() && !method.told_load(),
        _ => false,
    };
    Candidate {
        index,
        rms: all().map(|cutting| cutting.rms).fold(0.0, f64::max),
        max,
        within: max <= tolerance_um,
        told_nothing,
    }
}

/// The best of the candidates, by its place in the list of methods.
fn preferred(candidates: &[Candidate], none: Option<ErrorStats>) -> Option<usize> {
    let by_merit = |a: &&Candidate, b: &&Candidate| {
        b.within
            .cmp(&a.within)
            .then(a.rms.total_cmp(&b.rms))
            .then(a.max.total_cmp(&b.max))
            // The first of equals.
            .then(a.index.cmp(&b.index))
    };
    let best = candidates.iter().min_by(by_merit)?;
    let near = none
        .map_or(0.0, |none| NEAR_BEST_SHARE * none.rms)
        .max(HARM_UM);
    let untold = candidates
        .iter()
        .filter(|candidate| candidate.told_nothing)
        .min_by(by_merit)
        .filter(|untold| untold.within >= best.within && untold.rms <= best.rms + near);
    Some(untold.unwrap_or(best).index)
}

/// Says on which side a gap should err that the recommended method is told, where it matters.
pub(crate) fn note_side(results: &mut [MethodResult], recommended: Option<&str>) {
    let mut results = results.iter_mut();
    let Some(result) = results.find(|result| Some(result.method.as_str()) == recommended) else {
        return;
    };
    let told = |large: bool| {
        let mut runs = result.misled.iter();
        runs.find(|run| run.misled.what == Told::Gap && (run.misled.factor > 1.0) == large)
    };
    let (Some(small), Some(large)) = (told(false), told(true)) else {
        return;
    };
    if large.cutting.rms > small.cutting.rms + HARM_UM {
        let percent = (large.misled.factor - 1.0) * 100.0;
        result.notes.push(format!(
            "tell it a gap rather too small than too large (`gap_uncertainty`): RMS {:.2} um with {percent:.0} % too large, {:.2} um with {percent:.0} % too small",
            large.cutting.rms, small.cutting.rms
        ));
    }
}

/// A method that is best where everything is told right, and not recommended where something is
/// told wrong.
pub(crate) struct Doubt {
    /// Its place among the methods.
    pub(crate) method: usize,
    /// What it cannot be told wrong.
    told: Vec<Told>,
    /// By how much these are told wrong where it is tried again, the largest first.
    shares: Vec<f64>,
}

/// Whether the recommendation leaves a better method out because of what may be told wrong.
pub(crate) fn doubt(
    run: &Run,
    choices: &[Choice],
    refused: impl Fn(&Choice) -> Option<String>,
    share: Option<f64>,
) -> Option<Doubt> {
    let none = run
        .results
        .iter()
        .find(|result| result.is_baseline() && result.stop.is_none())
        .map(|result| result.cutting);
    let place = |name: &str| run.results.iter().position(|result| result.method == name);
    let recommended = place(run.recommended.as_deref()?)?;
    // Ruled out for another reason than what may be told wrong: out whatever is known.
    let tolerance_um = run.tolerance_um;
    let mut right = Vec::new();
    for (index, (result, choice)) in run.results.iter().zip(choices).enumerate() {
        let told_right = MethodResult {
            misled: Vec::new(),
            ..result.clone()
        };
        if refused(choice).is_none() && unsafe_in(&told_right, none).is_none() {
            right.push(candidate(index, &told_right, choice, tolerance_um));
        }
    }
    let method = preferred(&right, none)?;
    let result = run.results.get(method)?;
    if method == recommended || result.misled.is_empty() {
        return None;
    }
    // Each quantity alone, told as wrong as it was.
    let fails = |what: &Told| {
        let misled = result.misled.iter().filter(|run| run.misled.what == *what);
        let alone = MethodResult {
            misled: misled.copied().collect(),
            ..result.clone()
        };
        !alone.misled.is_empty() && !goes_before(&alone, method, run, choices)
    };
    let told: Vec<Told> = Told::ALL.into_iter().filter(fails).collect();
    if told.is_empty() {
        return None;
    }
    let share = share.unwrap_or(USUAL_SHARE);
    Some(Doubt {
        method,
        told,
        shares: LESS_WRONG.map(|part| part * share).to_vec(),
    })
}

/// Whether a method with these runs is safe, and better than the one that is recommended.
fn goes_before(result: &MethodResult, index: usize, run: &Run, choices: &[Choice]) -> bool {
    let baseline = run.results.iter().find(|result| result.is_baseline());
    let none = baseline
        .filter(|result| result.stop.is_none())
        .map(|result| result.cutting);
    let recommended = run
        .results
        .iter()
        .position(|other| Some(&other.method) == run.recommended.as_ref());
    let Some(other) = recommended else {
        return false;
    };
    let both = [
        candidate(index, result, &choices[index], run.tolerance_um),
        candidate(
            other,
            &run.results[other],
            &choices[other],
            run.tolerance_um,
        ),
    ];
    unsafe_in(result, none).is_none() && preferred(&both, none) == Some(index)
}

impl Doubt {
    /// The runs in which it is tried again, of the only method.
    pub(crate) fn runs(&self) -> Vec<(usize, Misled)> {
        let mut runs = Vec::new();
        for share in &self.shares {
            for what in &self.told {
                for factor in [1.0 - share, 1.0 + share] {
                    runs.push((
                        0,
                        Misled {
                            what: *what,
                            factor,
                        },
                    ));
                }
            }
        }
        runs
    }

    /// What it would take, from how it did in [`Doubt::runs`].
    pub(crate) fn answer(&self, run: &Run, choices: &[Choice], tried: &[MisledResult]) -> Trust {
        let result = &run.results[self.method];
        let least = self.shares.last().copied().unwrap_or(0.0);
        let mut trust = Trust {
            method: result.method.clone(),
            told: self.told.clone(),
            within: None,
            least,
        };
        // What may be told as wrong as before stays so; the rest is told less and less wrong.
        let others = result.misled.iter();
        let others = others.filter(|run| !self.told.contains(&run.misled.what));
        let others: Vec<MisledResult> = others.copied().collect();
        // From the least on: a method is trusted as far as it is safe in all that is less wrong.
        let mut misled = others;
        let group = 2 * self.told.len();
        for (share, runs) in self.shares.iter().zip(tried.chunks(group.max(1))).rev() {
            misled.extend(runs);
            let so_far = MethodResult {
                misled: misled.clone(),
                ..result.clone()
            };
            if !goes_before(&so_far, self.method, run, choices) {
                break;
            }
            trust.within = Some(*share);
        }
        trust
    }
}

impl MisledResult {
    /// ` if told a gap 30 % too large`.
    fn when(&self) -> String {
        let Misled { what, factor } = self.misled;
        // As it was asked for, without what the rounding of the factor adds.
        let percent = number(((factor - 1.0).abs() * 1e8).round() / 1e6);
        let side = if factor > 1.0 { "large" } else { "small" };
        format!(" if told a {} {percent} % too {side}", what.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_methods::MethodId;

    fn errors(max: f64, rms: f64) -> ErrorStats {
        ErrorStats {
            max,
            rms,
            ..ErrorStats::default()
        }
    }

    /// A method that leaves these errors: largest and RMS, as it stands and misled.
    fn method(name: &str, right: (f64, f64), misled: &[(f64, f64)]) -> (MethodResult, Choice) {
        let result = MethodResult {
            method: name.to_owned(),
            cutting: errors(right.0, right.1),
            misled: misled
                .iter()
                .map(|(max, rms)| MisledResult {
                    misled: Misled {
                        what: Told::Gap,
                        factor: 1.3,
                    },
                    cutting: errors(*max, *rms),
                    backlash: ErrorStats::default(),
                    stops: false,
                })
                .collect(),
            ..MethodResult::default()
        };
        let method = name.parse().unwrap_or_default();
        (result, Choice::Registered(method))
    }

    /// What is recommended within 20 um, and the reasons against the methods.
    fn told(
        methods: impl IntoIterator<Item = (MethodResult, Choice)>,
    ) -> (Option<String>, Vec<Option<String>>) {
        let (mut results, choices): (Vec<_>, Vec<_>) = methods.into_iter().unzip();
        let scale = |choice: &Choice| {
            let Choice::Registered(method) = choice else {
                return None;
            };
            method.needs_load_scale().then(|| "scale".to_owned())
        };
        let best = recommend(&mut results, &choices, scale, 20.0);
        (
            best,
            results.into_iter().map(|r| r.not_recommended).collect(),
        )
    }

    #[test]
    fn what_is_worse_than_none_in_any_run_is_never_recommended() {
        let none = || method("none", (25.0, 5.0), &[]);
        // Exact values: a tenth; a gap told too large: a higher peak.
        let lookup = method("lookup", (2.0, 0.5), &[(3.0, 1.0), (25.3, 1.0)]);
        let (best, reasons) = told([none(), lookup, method("fixed", (18.0, 4.0), &[(19.0, 4.5)])]);
        assert_eq!(best.as_deref(), Some("fixed"));
        let text = "worse than none if told a gap 30 % too large: contour error max 25.30 um against 25.00 um";
        assert_eq!(reasons[1].as_deref(), Some(text));
        // Worse as it stands; not a number counts as worse.
        let bad = [
            method("fixed", (24.0, 5.2), &[]),
            method("lookup", (f64::NAN, 1.0), &[]),
        ];
        let (best, reasons) = told(std::iter::once(none()).chain(bad));
        assert_eq!(best.as_deref(), Some("none"));
        assert!(reasons[1..].iter().all(Option::is_some), "{reasons:?}");
        // What stops the machine, and what does if it is told something wrong.
        let mut thrown = method("fixed", (1.0, 0.1), &[]);
        thrown.0.stop = Some(Default::default());
        let mut misled = method("lookup", (1.0, 0.1), &[(1.0, 0.1)]);
        misled.0.misled[0].stops = true;
        let (best, reasons) = told([none(), thrown, misled]);
        assert_eq!(best.as_deref(), Some("none"));
        assert_eq!(reasons[1].as_deref(), Some("the machine stops"));
        let text = "the machine stops if told a gap 30 % too large";
        assert_eq!(reasons[2].as_deref(), Some(text));
        // What the machine does not have.
        let (best, reasons) = told([none(), method("load-feedback", (1.0, 0.1), &[])]);
        assert_eq!(best.as_deref(), Some("none"));
        assert_eq!(reasons[1].as_deref(), Some("scale"));
    }

    #[test]
    fn a_method_is_misled_in_all_that_it_is_told_or_remembers() {
        let runs = |name: &str, remembers| {
            let choices = [
                Choice::Registered(MethodId::NONE),
                Choice::Registered(name.parse().unwrap()),
            ];
            let runs = misled_runs(&choices, None, remembers);
            assert!(runs.iter().all(|(index, _)| *index == 1));
            runs.len()
        };
        for (name, cold, warm) in [
            ("none", 0, 0),
            ("fixed", 2, 2),
            ("lookup", 6, 6),
            ("adaptive", 2, 6),
            ("load-feedback", 0, 0),
        ] {
            assert_eq!(
                (runs(name, false), runs(name, true)),
                (cold, warm),
                "{name}"
            );
        }
    }

    #[test]
    fn what_it_would_take_is_the_largest_part_that_is_safe_with_all_below() {
        let (results, choices): (Vec<_>, Vec<_>) = [
            method("none", (25.0, 5.0), &[]),
            method("lookup", (2.0, 0.5), &[(3.0, 1.0), (25.3, 1.0)]),
            method("fixed", (18.0, 4.0), &[(19.0, 4.5)]),
        ]
        .into_iter()
        .unzip();
        let mut run = Run {
            tolerance_um: 20.0,
            results,
            ..Run::default()
        };
        run.recommended = recommend(&mut run.results, &choices, |_| None, 20.0);
        assert_eq!(run.recommended.as_deref(), Some("fixed"));
        let doubt = doubt(&run, &choices, |_| None, None).unwrap();
        assert_eq!((doubt.method, &doubt.told), (1, &vec![Told::Gap]));
        assert_eq!(doubt.runs().len(), 6);
        // How it does with 0.75, 0.5 and 0.25 of the part: the largest errors.
        let within = |max: [f64; 3]| {
            let runs: Vec<MisledResult> = max
                .into_iter()
                .flat_map(|max| [max; 2])
                .zip(doubt.runs())
                .map(|(max, (_, misled))| MisledResult {
                    misled,
                    cutting: errors(max, 1.0),
                    ..MisledResult::default()
                })
                .collect();
            let trust = doubt.answer(&run, &choices, &runs);
            assert_eq!((trust.method.as_str(), trust.least), ("lookup", 0.25 * 0.3));
            trust.within.map(|share| (share * 1e3).round())
        };
        assert_eq!(within([24.0, 10.0, 5.0]), Some(150.0));
        assert_eq!(within([15.0, 10.0, 5.0]), Some(225.0));
        // Safe with half but not with a quarter: not to be trusted.
        assert_eq!(within([15.0, 10.0, 30.0]), None);
    }

    #[test]
    fn the_tolerance_goes_first_and_the_worst_run_counts() {
        let none = || method("none", (40.0, 8.0), &[]);
        // The smaller RMS, but out of tolerance once a value is wrong.
        let lookup = method("lookup", (5.0, 1.0), &[(22.0, 1.5)]);
        let fixed = method("fixed", (18.0, 3.0), &[(19.0, 4.0)]);
        assert_eq!(told([none(), lookup, fixed]).0.as_deref(), Some("fixed"));
        let lookup = method("lookup", (5.0, 1.0), &[(12.0, 4.5)]);
        let fixed = method("fixed", (18.0, 3.0), &[(19.0, 4.0)]);
        assert_eq!(told([none(), lookup, fixed]).0.as_deref(), Some("fixed"));
    }

    #[test]
    fn a_method_that_is_told_nothing_goes_before_one_that_is_hardly_better() {
        let with = |adaptive: f64| {
            let methods = [
                method("none", (9.0, 5.0), &[]),
                method("lookup", (1.0, 0.1), &[(1.0, 0.1)]),
                method("adaptive", (1.0, adaptive), &[]),
            ];
            told(methods).0
        };
        assert_eq!(with(0.34).as_deref(), Some("adaptive"));
        assert_eq!(with(0.36).as_deref(), Some("lookup"));
        assert_eq!(told([]).0, None);
        assert_eq!(told([method("fixed", (1.0, 1.0), &[])]).0, None);
    }
}
