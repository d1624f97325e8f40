//! Time stamps in text: seconds, or date and time, or time of day, in seconds from the first row.

use super::decimal::DecimalMark;
use crate::table::TimeOrigin;

/// Values expected in a cell of time.
pub(super) const EXPECTED: &str = "seconds, or a time such as 2026-11-22T10:11:12.345Z or 2026-11-22 10:11:12.345, \
                                   in every row with or in every row without a zone";
/// Values expected in place of a date such as `3/4/2026`.
const EXPECTED_ORDER: &str = "a date whose day and month are certain, such as 2026-11-22 or 22.11.2026";
/// Values expected in place of a time zone by name.
const EXPECTED_ZONE: &str = "a zone by its offset, such as 2026-11-22T10:11:12.345+01:00, or UTC, as names of zones are \
                             ambiguous at the end of summer time";
/// Values expected in place of minutes and seconds.
const EXPECTED_CLOCK: &str = "a time of day with hours, minutes and seconds, such as 10:11:12.345";

const NANOSECONDS_PER_DAY: i128 = 86_400_000_000_000;

/// Form and origin of the time stamps of a file.
#[derive(Debug, Default)]
pub(super) struct TimeStamps {
    first: Option<First>,
    /// Last time of day, in nanoseconds from the first midnight.
    last: i128,
}

/// The first time stamp.
#[derive(Debug, Clone, Copy)]
enum First {
    Seconds,
    Date(TimeOrigin),
}

impl TimeStamps {
    /// Returns true for a date and time or a time of day.
    pub(super) fn is_date(cell: &[u8]) -> bool {
        date(cell).is_some()
    }

    /// Returns the date of the first row; none before it, and where the time stamps are seconds.
    pub(super) const fn origin(&self) -> Option<TimeOrigin> {
        match self.first {
            Some(First::Date(date)) => Some(date),
            Some(First::Seconds) | None => None,
        }
    }

    /// Reads a cell, s; NaN for nothing. The difference to the first row is computed in whole nanoseconds.
    pub(super) fn read(&mut self, cell: &[u8], mark: DecimalMark) -> Option<f64> {
        let number = mark.number(cell);
        if number.is_some_and(f64::is_nan) {
            return number;
        }
        match (self.first, number) {
            (Some(First::Date(first)), None) => {
                let same_form = |date: &TimeOrigin| (date.has_zone, date.has_date) == (first.has_zone, first.has_date);
                let date = date(cell).filter(same_form)?;
                let now = if date.has_date { date.nanoseconds } else { self.after_midnight(date.nanoseconds) };
                self.last = now;
                Some((now - first.nanoseconds) as f64 / 1e9)
            }
            (None, None) => {
                let date = date(cell)?;
                (self.first, self.last) = (Some(First::Date(date)), date.nanoseconds);
                Some(0.0)
            }
            (None | Some(First::Seconds), Some(_)) => {
                self.first = Some(First::Seconds);
                number
            }
            (Some(First::Seconds), None) | (Some(First::Date(_)), Some(_)) => None,
        }
    }

    /// Returns a time of day on the day on which it is nearest to the last one.
    const fn after_midnight(&self, time: i128) -> i128 {
        let days = (self.last - time + NANOSECONDS_PER_DAY / 2).div_euclid(NANOSECONDS_PER_DAY);
        time + days * NANOSECONDS_PER_DAY
    }

    /// Returns the values expected in place of a cell that is none.
    pub(super) fn expected(cell: &[u8]) -> &'static str {
        let text = str::from_utf8(cell.trim_ascii()).unwrap_or_default();
        let (day, time) = text.split_once(['T', 't', ' ']).unwrap_or((text, ""));
        let is_day = |mark: char| day.split(mark).count() == 3 && day.split(mark).all(|part| digits(part).is_some());
        let zone = time.trim_start_matches(|letter: char| letter.is_ascii_digit() || ":., ".contains(letter));
        let is_year_first = day.split(['/', '-']).next().is_some_and(|year| year.len() == 4);
        let is_year_last = day.rsplit('.').next().is_some_and(|year| year.len() == 4);
        if (is_day('/') || is_day('-')) && !is_year_first || is_day('.') && !is_year_last {
            EXPECTED_ORDER
        } else if zone.len() > 1
            && zone.starts_with(|letter: char| letter.is_alphabetic())
            && !zone.starts_with(['Z', 'z'])
        {
            EXPECTED_ZONE
        } else if day.split(':').count() == 2 && day.split([':', '.', ',']).all(|part| digits(part).is_some()) {
            EXPECTED_CLOCK
        } else {
            EXPECTED
        }
    }
}

/// Reads `2026-11-22T10:11:12.345+01:00`: `T` or a blank, up to nine decimals after a point or comma, a zone or none; also
/// `22.11.2026 10:11:12`, `2026/11/22 10:11:12`, and a time of day alone, which needs its seconds.
fn date(cell: &[u8]) -> Option<TimeOrigin> {
    let text = str::from_utf8(cell.trim_ascii()).ok()?;
    let (day, time) = match text.split_once(['T', 't', ' ']) {
        Some((day, time)) if !day.contains(':') => (Some(day), time),
        _ => (None, text),
    };
    let day = match day {
        Some(day) => Some(day_of(day)?),
        None => None,
    };
    let (time, zone) = match time.find(['Z', 'z', '+', '-', 'U', 'G']) {
        Some(at) => time.split_at(at),
        None => (time, ""),
    };
    let (time, later) = half_of_day(time.trim_end());
    let (time, fraction) = time.split_once(['.', ',']).unwrap_or((time, "0"));
    let mut parts = time.split(':').map(digits);
    let (hour, minute, second) = (parts.next()??, parts.next()??, parts.next());
    if day.is_none() && second.is_none() {
        return None;
    }
    let second = second.unwrap_or(Some(0))?;
    let hour = match later {
        Some(later) => (1..=12).contains(&hour).then_some(hour % 12 + later)?,
        None => hour,
    };
    let is_time = hour < 24 && minute < 60 && second <= 60 && parts.next().is_none();
    if !is_time || fraction.len() > 9 {
        return None;
    }
    let fraction = digits(fraction)? * 10_i64.pow(9 - fraction.len() as u32);
    let seconds = day.unwrap_or(0) * 86_400 + hour * 3600 + minute * 60 + second - offset(zone)?;
    Some(TimeOrigin {
        nanoseconds: i128::from(seconds) * 1_000_000_000 + i128::from(fraction),
        has_zone: !zone.is_empty(),
        has_date: day.is_some(),
    })
}

/// Returns the days since 1970 of `2026-11-22`, `2026/11/22` or `22.11.2026`. Day and month of other forms are not certain.
fn day_of(text: &str) -> Option<i64> {
    let mark = text.chars().find(|letter| "-/.".contains(*letter))?;
    let mut parts = text.split(mark);
    let ([first, month, last], None) = ([parts.next()?, parts.next()?, parts.next()?], parts.next()) else {
        return None;
    };
    let (year, day) = if mark == '.' { (last, first) } else { (first, last) };
    let is_certain = year.len() == 4;
    let (year, month, day) = (digits(year)?, digits(month)?, digits(day)?);
    let is_date = (1..=12).contains(&month) && (1..=31).contains(&day) && year <= 9999;
    (is_date && is_certain).then(|| days(year, month, day))
}

/// Splits `10:11:12 PM` into the time and the hours of its half of the day.
fn half_of_day(time: &str) -> (&str, Option<i64>) {
    let halves = [("AM", 0), ("PM", 12), ("am", 0), ("pm", 12)];
    let found = halves.into_iter().find_map(|(half, hours)| Some((time.strip_suffix(half)?.trim_end(), Some(hours))));
    found.unwrap_or((time, None))
}

fn digits(text: &str) -> Option<i64> {
    if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) { None } else { text.parse().ok() }
}

/// Returns the seconds of a zone east of UTC.
fn offset(zone: &str) -> Option<i64> {
    let sign = match zone.get(..1) {
        None => return Some(0),
        Some("Z" | "z") => return (zone.len() == 1).then_some(0),
        Some("U" | "G") => return matches!(zone, "UTC" | "GMT").then_some(0),
        Some("-") => -1,
        Some(_) => 1,
    };
    let digits_of: String = zone.get(1..)?.chars().filter(|letter| *letter != ':').collect();
    let (hours, minutes) = match digits_of.len() {
        2 => (digits(&digits_of)?, 0),
        4 => (digits(digits_of.get(..2)?)?, digits(digits_of.get(2..)?)?),
        _ => return None,
    };
    (hours < 24 && minutes < 60).then_some(sign * (hours * 3600 + minutes * 60))
}

/// Returns the days from 1970-01-01 in the Gregorian calendar, with years that begin in March.
const fn days(year: i64, month: i64, day: i64) -> i64 {
    let year = if month > 2 { year } else { year - 1 };
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let leap_days = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    365 * year + leap_days + of_year - 719_468
}
