//! Plans a simple program and writes its samples as CSV: `plan_csv PROGRAM OUT.csv [optimal]`.
//!
//! Reads what the planner's benchmark programs consist of, and nothing else: G0 to G3 with X Y Z I
//! J, F, G61, G61.1, G64 P. The machine has 100 mm/s, 1000 mm/s2 and 30,000 mm/s3 on each of X, Y
//! and Z.

use lostmotion_base::{AxisLimits, BlockRef, Coords};
use lostmotion_kinematics::{CartesianSpec, build};
use lostmotion_path::{Arc as PathArc, ArcSpec, Curve, Plane};
use lostmotion_plan::{
    FeedLimit, Move, PathControl, PlanItem, Planner, PlannerConfig, Quality, Sample,
};
use std::error::Error;
use std::fmt::Write as _;
use std::sync::Arc;
use std::time::Instant;

struct Reader {
    here: Coords,
    motion: u32,
    feed: f64,
    control: PathControl,
    line: u32,
}

/// Letters and numbers of a block without its comment.
fn words(line: &str) -> Vec<(char, f64)> {
    let code = line.split('(').next().unwrap_or("");
    let mut out = Vec::new();
    let mut rest = code.trim();
    while let Some(letter) = rest.chars().next() {
        let number = &rest[letter.len_utf8()..];
        let end = number
            .find(|c: char| c.is_ascii_alphabetic())
            .unwrap_or(number.len());
        if let Ok(value) = number[..end].trim().parse() {
            out.push((letter.to_ascii_uppercase(), value));
        }
        rest = number[end..].trim_start();
    }
    out
}

impl Reader {
    fn read(&mut self, line: &str) -> Result<Option<Move>, Box<dyn Error>> {
        self.line += 1;
        let words = words(line);
        let word = |letter: char| {
            words
                .iter()
                .find(|(l, _)| *l == letter)
                .map(|(_, value)| *value)
        };
        for (_, code) in words.iter().filter(|(letter, _)| *letter == 'G') {
            match (code * 10.0).round() as u32 {
                code @ (0 | 10 | 20 | 30) => self.motion = code / 10,
                610 => self.control = PathControl::ExactPath,
                611 => self.control = PathControl::ExactStop,
                640 => {
                    self.control = PathControl::Continuous {
                        tolerance_mm: word('P'),
                        merge_tolerance_mm: None,
                    }
                }
                _ => {}
            }
        }
        self.feed = word('F').map_or(self.feed, |f| f / 60.0);
        if !['X', 'Y', 'Z']
            .into_iter()
            .any(|letter| word(letter).is_some())
        {
            return Ok(None);
        }
        let [x, y, z] = self.here.linear();
        let end = Coords::xyz(
            word('X').unwrap_or(x),
            word('Y').unwrap_or(y),
            word('Z').unwrap_or(z),
        );
        let curve = match self.motion {
            2 | 3 => {
                let center = [x + word('I').unwrap_or(0.0), y + word('J').unwrap_or(0.0)];
                let turns = word('P').unwrap_or(1.0) as i32;
                let rotation = if self.motion == 3 { turns } else { -turns };
                Curve::Arc(PathArc::new(ArcSpec {
                    start: self.here,
                    end,
                    plane: Plane::Xy,
                    center,
                    rotation,
                })?)
            }
            _ => Curve::line(self.here, end),
        };
        self.here = end;
        let feed = if self.motion == 0 {
            FeedLimit::Rapid
        } else {
            FeedLimit::PerSecond(self.feed)
        };
        let mut block = BlockRef::default();
        block.span.line = self.line;
        Ok(Some(Move {
            curve,
            feed,
            control: self.control,
            tool_mm: [0.0; 3],
            block,
        }))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let (Some(program), Some(out)) = (args.next(), args.next()) else {
        return Err("usage: plan_csv PROGRAM OUT.csv [optimal]".into());
    };
    let limits = AxisLimits {
        min: -1e6,
        max: 1e6,
        velocity: 100.0,
        acceleration: 1e3,
        jerk: 3e4,
    };
    let mut config = PlannerConfig::new([None; 9]);
    config.limits[..3].fill(Some(limits));
    if args.next().as_deref() == Some("optimal") {
        config.quality = Quality::Optimal;
    }
    let kinematics = build(&CartesianSpec {}.into())?;
    let mut planner = Planner::new(config, Arc::from(kinematics), Coords::ZERO)?;
    let control = PathControl::Continuous {
        tolerance_mm: None,
        merge_tolerance_mm: None,
    };
    let mut reader = Reader {
        here: Coords::ZERO,
        motion: 1,
        feed: 0.0,
        control,
        line: 0,
    };
    let text = std::fs::read_to_string(program)?;
    let mut samples: Vec<Sample> = Vec::new();
    let mut held = 0;
    let begin = Instant::now();
    for line in text.lines() {
        if let Some(item) = reader.read(line)? {
            planner.push(PlanItem::Move(item))?;
            held = held.max(planner.held_pieces());
            planner.take(usize::MAX, &mut samples);
        }
    }
    planner.finish()?;
    planner.take(usize::MAX, &mut samples);
    let seconds = begin.elapsed().as_secs_f64();
    let mut csv = String::from("t_s,x_mm,y_mm,z_mm\n");
    for sample in &samples {
        let [x, y, z] = sample.position.linear();
        writeln!(
            csv,
            "{:.3},{x:.12},{y:.12},{z:.12}",
            sample.tick as f64 * 1e-3
        )?;
    }
    std::fs::write(out, csv)?;
    eprintln!(
        "{} samples in {seconds:.4} s, {held} pieces held, {:?}",
        samples.len(),
        planner.shortfalls()
    );
    Ok(())
}
