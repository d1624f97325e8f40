//! Time stamps in text: seconds, or date and time of ISO 8601, in seconds from the first row.

use super::decimal::DecimalMark;
use crate::recording::table::TimeOrigin;

/// Values expected in a cell of time.
pub(super) const EXPECTED: &str = "seconds, or a time such as 2026-11-22T10:11:12.345Z or 2026-11-22 10:11:12.345, \
                                   in every row with or in every row without a zone";

/// Form and origin of the time stamps of a file.
#[derive(Debug, Default)]
pub(super) struct TimeStamps {
    first: Option<First>,
}

/// The first time stamp.
#[derive(Debug, Clone, Copy)]
enum First {
    Seconds,
    Date(TimeOrigin),
}

impl TimeStamps {
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
                let date = date(cell).filter(|date| date.has_zone == first.has_zone)?;
                Some((date.nanoseconds - first.nanoseconds) as f64 / 1e9)
            }
            (None, None) => {
                self.first = Some(First::Date(date(cell)?));
                Some(0.0)
            }
            (None | Some(First::Seconds), Some(_)) => {
                self.first = Some(First::Seconds);
                number
            }
            (Some(First::Seconds), None) | (Some(First::Date(_)), Some(_)) => None,
        }
    }
}

/// Reads `2026-11-22T10:11:12.345+01:00`: `T` or a blank, up to nine decimals after a point or comma, a zone or none.
fn date(cell: &[u8]) -> Option<TimeOrigin> {
    let text = str::from_utf8(cell.trim_ascii()).ok()?;
    let (day, time) = text.split_once(['T', 't', ' '])?;
    let mut parts = day.split('-').map(digits);
    let ([year, month, day], None) = ([parts.next()??, parts.next()??, parts.next()??], parts.next()) else {
        return None;
    };
    let (time, zone) = match time.find(['Z', 'z', '+', '-']) {
        Some(at) => time.split_at(at),
        None => (time, ""),
    };
    let (time, fraction) = time.trim_end().split_once(['.', ',']).unwrap_or((time.trim_end(), "0"));
    let mut parts = time.split(':').map(digits);
    let (hour, minute, second) = (parts.next()??, parts.next()??, parts.next().unwrap_or(Some(0))?);
    let is_time = hour < 24 && minute < 60 && second <= 60 && parts.next().is_none();
    let is_date = (1..=12).contains(&month) && (1..=31).contains(&day) && year <= 9999;
    if !is_time || !is_date || fraction.len() > 9 {
        return None;
    }
    let fraction = digits(fraction)? * 10_i64.pow(9 - fraction.len() as u32);
    let seconds = days(year, month, day) * 86_400 + hour * 3600 + minute * 60 + second - offset(zone)?;
    Some(TimeOrigin {
        nanoseconds: i128::from(seconds) * 1_000_000_000 + i128::from(fraction),
        has_zone: !zone.is_empty(),
    })
}

fn digits(text: &str) -> Option<i64> {
    if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) { None } else { text.parse().ok() }
}

/// Returns the seconds of a zone east of UTC.
fn offset(zone: &str) -> Option<i64> {
    let sign = match zone.get(..1) {
        None => return Some(0),
        Some("Z" | "z") => return (zone.len() == 1).then_some(0),
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
