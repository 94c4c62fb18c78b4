//! Hints for names that are not known.

/// A hint for an unknown name: the known one that it begins (a key without its unit), the nearest
/// one if it is near, else all of them.
pub fn did_you_mean(unknown: &str, known: &[&str]) -> String {
    // A key without its unit, such as `gap` for `gap_um`.
    if let Some(name) = known.iter().find(|name| {
        name.strip_prefix(unknown)
            .is_some_and(|rest| rest.starts_with('_'))
    }) {
        return format!("did you mean `{name}`?");
    }
    let near = known
        .iter()
        .map(|name| (distance(unknown, name), name))
        .min();
    match near {
        // Near: two letters, or a third of a long name.
        Some((steps, name)) if steps <= 2.max(unknown.len() / 3) => {
            format!("did you mean `{name}`?")
        }
        Some(_) => format!("known here: {}", known.join(", ")),
        None => String::new(),
    }
}

/// Longest name that [`nearest`] compares, bytes: the comparison takes time with its square. A choice.
const MOST_COMPARED: usize = 64;
/// Most names that [`nearest`] looks at. A choice: a hint need not search millions.
const MOST_NAMES: usize = 10_000;

/// The name of many that an unknown one is most likely meant to be: one letter in three may differ.
/// `None` if none is near; numbers have no near ones.
pub fn nearest<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let is_number = unknown.bytes().all(|byte| byte.is_ascii_digit());
    if is_number || unknown.len() > MOST_COMPARED {
        return None;
    }
    let most = unknown.chars().count() / 3;
    let near = known
        .into_iter()
        .take(MOST_NAMES)
        .filter(|name| name.len() <= MOST_COMPARED)
        .map(|name| (distance(unknown, name), name));
    near.filter(|(steps, _)| (1..=most).contains(steps))
        .min()
        .map(|(_, name)| name)
}

/// Levenshtein's distance: insertions, deletions and replacements of letters that lead from one
/// name to the other.
fn distance(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    // One row of Wagner and Fischer's table: the distances from the letters so far to each
    // beginning of `to`.
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, a) in from.chars().enumerate() {
        // Neighbours of the next cell: diagonal is one letter less of both, left one less of `to`.
        let mut diagonal = i;
        let mut left = i + 1;
        for (j, b) in to.iter().enumerate() {
            let above = row.get(j + 1).copied().unwrap_or(left);
            // Replace or keep the letter, delete it, or insert one.
            let cell = (diagonal + usize::from(a != *b))
                .min(above + 1)
                .min(left + 1);
            if let Some(slot) = row.get_mut(j) {
                *slot = left;
            }
            diagonal = above;
            left = cell;
        }
        // The last cell of the row is still pending.
        if let Some(slot) = row.last_mut() {
            *slot = left;
        }
    }
    row.last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_of_known_words() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("abc", ""), 3);
        assert_eq!(distance("gap_um", "gap_um"), 0);
        assert_eq!(distance("flaw", "lawn"), 2);
    }

    #[test]
    fn only_a_slip_of_the_keys_is_near() {
        assert_eq!(nearest("pokcet", ["slot", "pocket"]), Some("pocket"));
        assert_eq!(nearest("feeed", ["fed", "feed"]), Some("feed"));
        assert_eq!(nearest("hole", ["drill", "slot"]), None);
        assert_eq!(nearest("101", ["100"]), None);
        assert_eq!(nearest("a", ["b"]), None);
    }

    #[test]
    fn near_names_are_offered_and_far_ones_listed() {
        assert_eq!(
            did_you_mean("lead_nm", &["gear", "lead_mm"]),
            "did you mean `lead_mm`?"
        );
        assert_eq!(
            did_you_mean("mass", &["lead_mm", "mass_kg"]),
            "did you mean `mass_kg`?"
        );
        assert_eq!(
            did_you_mean("colour", &["gear", "lead_mm"]),
            "known here: gear, lead_mm"
        );
    }
}
