//! Numeric fields of the results: their names and units stand once, for all outputs.

/// Unit of the fields that are in the unit of their sensor.
pub const UNIT_OF_SENSOR: &str = "unit of the sensor";

/// Numeric field of `T`.
///
/// JSON has its key. CSV and Parquet files have one column for each field, Prometheus one metric, the tables of a report one column.
#[derive(Debug)]
pub struct NumericField<T, V = f64> {
    /// Key in JSON, which is also the end of the names of columns and metrics.
    pub key: &'static str,
    /// Heading on a page.
    pub name: &'static str,
    /// Heading in a text where it is not the name.
    short_name: Option<&'static str>,
    /// Unit in tables; empty without one.
    pub unit: &'static str,
    /// Number of decimals in tables; none where the largest number of a column determines it.
    pub decimals: Option<usize>,
    /// Description.
    pub help: &'static str,
    /// Returns its value; not a number where it is absent.
    pub value: fn(&T) -> V,
}

impl<T, V> NumericField<T, V> {
    /// Creates a field.
    #[must_use]
    pub const fn new(key: &'static str, name: &'static str, unit: &'static str, value: fn(&T) -> V) -> Self {
        Self { key, name, short_name: None, unit, decimals: None, help: "", value }
    }

    /// Returns the field of this key.
    #[must_use]
    pub fn find<'a>(fields: &'a [Self], key: &str) -> Option<&'a Self> {
        fields.iter().find(|field| field.key == key)
    }

    /// Sets the heading in texts.
    #[must_use]
    pub const fn short(self, name: &'static str) -> Self {
        Self { short_name: Some(name), ..self }
    }

    /// Sets the number of decimals.
    #[must_use]
    pub const fn decimals(self, decimals: usize) -> Self {
        Self { decimals: Some(decimals), ..self }
    }

    /// Sets the description.
    #[must_use]
    pub const fn help(self, help: &'static str) -> Self {
        Self { help, ..self }
    }

    /// Returns the name with the unit, as the title of an axis.
    #[must_use]
    pub fn title(&self) -> String {
        if self.unit.is_empty() { self.name.to_owned() } else { format!("{}, {}", self.name, self.unit) }
    }

    /// Returns the heading in a text: the name without its capital, unless it is an abbreviation.
    #[must_use]
    pub fn text_name(&self) -> String {
        let mut letters = self.name.chars();
        match (self.short_name, letters.next(), letters.as_str()) {
            (Some(name), ..) => name.to_owned(),
            (None, Some(first), rest) if !rest.starts_with(char::is_uppercase) => {
                first.to_lowercase().chain(rest.chars()).collect()
            }
            _ => self.name.to_owned(),
        }
    }
}
