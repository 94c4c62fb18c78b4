//! Points in time as logs write them.

/// Seconds in a day.
const DAY_S: f64 = 86_400.0;

/// Days from 1970-01-01 to a date of the Gregorian calendar.
fn days(year: i64, month: i64, day: i64) -> i64 {
    // Years begin in March, so that the leap day is their last.
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let of_years = 365 * year + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    let of_months = (153 * month + 2) / 5;
    of_years + of_months + day - 1 - 719_468
}

/// A date `2026-03-20` (or with slashes) as days from 1970-01-01.
pub(crate) fn date_days(text: &str) -> Option<i64> {
    let mut parts = text.split(['-', '/']);
    let mut next = || -> Option<i64> {
        let part = parts.next()?;
        (part.len() <= 4 && part.bytes().all(|byte| byte.is_ascii_digit())).then_some(())?;
        part.parse().ok()
    };
    let (year, month, day) = (next()?, next()?, next()?);
    let plausible = (1601..=9999).contains(&year)
        && (1..=12).contains(&month)
        && (1..=31).contains(&day)
        && parts.next().is_none();
    plausible.then(|| days(year, month, day))
}

/// A time of day `19:03:23.992` as seconds.
pub(crate) fn clock_s(text: &str) -> Option<f64> {
    let text = text.trim_end_matches('Z');
    let mut parts = text.split(':');
    let (hours, minutes, seconds) = (parts.next()?, parts.next()?, parts.next()?);
    if parts.next().is_some() || hours.len() > 2 || minutes.len() != 2 {
        return None;
    }
    let hours: u32 = hours.parse().ok()?;
    let minutes: u32 = minutes.parse().ok()?;
    let seconds: f64 = seconds.replacen(',', ".", 1).parse().ok()?;
    let plausible = hours < 24 && minutes < 60 && (0.0..61.0).contains(&seconds);
    plausible.then(|| f64::from(hours) * 3600.0 + f64::from(minutes) * 60.0 + seconds)
}

/// A date and a time of day: days since 1970-01-01 and seconds of the day. Apart, so that no
/// microsecond is lost in a large number.
pub(crate) fn stamp(text: &str) -> Option<(i64, f64)> {
    let (date, clock) = text.trim().split_once([' ', 'T'])?;
    Some((date_days(date)?, clock_s(clock.trim())?))
}

/// Seconds between two stamps.
pub(crate) fn between_s(first: (i64, f64), second: (i64, f64)) -> f64 {
    (second.0 - first.0) as f64 * DAY_S + (second.1 - first.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_count_days() {
        assert_eq!(date_days("1970-01-01"), Some(0));
        assert_eq!(date_days("2000-03-01"), Some(11_017));
        assert_eq!(date_days("2023/03/20"), Some(19_436));
        assert_eq!(date_days("1601-01-01"), Some(-134_774));
        assert_eq!(date_days("2023-13-20"), None);
        let (a, b) = (
            stamp("2023-03-20 23:59:59.5"),
            stamp("2023-03-21T00:00:00.25Z"),
        );
        assert_eq!(between_s(a.unwrap(), b.unwrap()), 0.75);
        assert_eq!(clock_s("25:00:00"), None);
    }
}
