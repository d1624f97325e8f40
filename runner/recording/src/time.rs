//! Time of a recording.

use chrono::{DateTime, NaiveDate, NaiveDateTime, SecondsFormat, Utc};
use serde::{Deserialize, Serialize};
use std::fmt::{Display, Formatter};

const SECONDS_PER_DAY: f64 = 86_400.0;
/// Forms of a date with a time of day.
const FORMS: [&str; 4] = ["%Y-%m-%dT%H:%M:%S%.f", "%Y-%m-%d %H:%M:%S%.f", "%Y-%m-%dT%H:%M", "%Y-%m-%d %H:%M"];

/// Time of a recording, to the second. It is displayed and serialised in UTC, such as `2026-01-31T08:00:00Z`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Time(DateTime<Utc>);

impl Time {
    /// Text of the allowed forms, for messages.
    pub const ALLOWED: &'static str = "an ISO 8601 date or date and time, such as 2026-01-31 or 2026-01-31T08:00:00Z";

    /// Parses an ISO 8601 date or date and time. A date is its beginning; a time without an offset is in UTC.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let local = || FORMS.iter().find_map(|form| NaiveDateTime::parse_from_str(text, form).ok());
        let date = || NaiveDate::parse_from_str(text, "%Y-%m-%d").ok()?.and_hms_opt(0, 0, 0);
        let offset = || DateTime::parse_from_rfc3339(text).ok().map(|time| time.to_utc());
        // A year of other than four digits is a typing error.
        let has_year = text.find('-') == Some(4);
        let time = offset().or_else(|| local().or_else(date).map(|time| time.and_utc()))?;
        has_year.then_some(Self(time))
    }

    /// Returns the days from `other` to this time.
    #[must_use]
    pub fn days_since(self, other: Self) -> f64 {
        (self.0 - other.0).as_seconds_f64() / SECONDS_PER_DAY
    }

    /// Returns the time `days` later, to the second; none beyond the year 9999.
    #[must_use]
    pub fn after_days(self, days: f64) -> Option<Self> {
        let seconds = self.0.timestamp() as f64 + (days * SECONDS_PER_DAY).round();
        let latest = NaiveDate::from_ymd_opt(9999, 12, 31)?.and_hms_opt(0, 0, 0)?.and_utc().timestamp() as f64;
        if !seconds.is_finite() || seconds.abs() > latest {
            return None;
        }
        DateTime::from_timestamp(seconds as i64, 0).map(Self)
    }

    /// Returns the date in UTC, such as `2026-01-31`.
    #[must_use]
    pub fn date(self) -> String {
        self.0.format("%Y-%m-%d").to_string()
    }
}

impl Display for Time {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0.to_rfc3339_opts(SecondsFormat::Secs, true))
    }
}

impl From<Time> for String {
    fn from(time: Time) -> Self {
        time.to_string()
    }
}

impl TryFrom<String> for Time {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        Self::parse(&text).ok_or_else(|| format!("invalid time: {text:?}, expected {}", Self::ALLOWED))
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn iso_8601_is_read_and_nothing_else() {
        let read = |text: &str| Time::parse(text).map(|time| time.to_string());
        assert_eq!(read("2026-01-31").as_deref(), Some("2026-01-31T00:00:00Z"));
        assert_eq!(read(" 2026-01-31T08:30 ").as_deref(), Some("2026-01-31T08:30:00Z"));
        assert_eq!(read("2026-01-31 08:30:15.25").as_deref(), Some("2026-01-31T08:30:15Z"));
        assert_eq!(read("2026-01-31T08:30:00+02:00").as_deref(), Some("2026-01-31T06:30:00Z"));
        for wrong in
            ["", "yesterday", "31.01.2026", "2026-02-30", "2026-13-01", "26-01-31", "2026-01-31T25:00", "12345-01-01"]
        {
            assert_eq!(read(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn days_are_added() {
        let time = Time::parse("2026-02-27").unwrap();
        let later = time.after_days(2.5).unwrap();
        assert_eq!(later.to_string(), "2026-03-01T12:00:00Z");
        assert_eq!(later.days_since(time), 2.5);
        assert!(time.after_days(1e9).is_none() && time.after_days(f64::NAN).is_none());
    }
}
