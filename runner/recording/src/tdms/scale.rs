//! Scales of raw values: conversion of counts to volts or metres by a channel's properties.
//!
//! `NI_Number_Of_Scales` counts them; scale `k` takes the raw values or an earlier scale's for its input, the last one
//! gives the channel's values.

use std::collections::BTreeMap;

/// Input of a scale that takes the raw values.
const RAW: f64 = u32::MAX as f64;

/// One scale.
#[derive(Debug, Default)]
struct Scale {
    kind: String,
    slope: Option<f64>,
    intercept: f64,
    input: f64,
}

/// All scales of a channel.
#[derive(Debug, Default)]
pub(super) struct Scales {
    count: u32,
    scaled: bool,
    all: BTreeMap<u32, Scale>,
}

impl Scales {
    /// Adds a property that is text.
    pub(super) fn text(&mut self, name: &str, value: &str) {
        if name == "NI_Scaling_Status" {
            self.scaled = value == "scaled";
        } else if let Some((scale, "Scale_Type")) = self.named(name) {
            scale.kind = value.to_owned();
        }
    }

    /// Adds a property that is a number.
    pub(super) fn number(&mut self, name: &str, value: f64) {
        if name == "NI_Number_Of_Scales" {
            self.count = value as u32;
            return;
        }
        let Some((scale, what)) = self.named(name) else { return };
        match what {
            "Linear_Slope" => scale.slope = Some(value),
            "Linear_Y_Intercept" => scale.intercept = value,
            "Linear_Input_Source" => scale.input = value,
            _ => {}
        }
    }

    /// Returns the scale of a property such as `NI_Scale[1]_Linear_Slope`, and the rest of the name.
    fn named<'a>(&mut self, name: &'a str) -> Option<(&mut Scale, &'a str)> {
        let (number, what) = name.strip_prefix("NI_Scale[")?.split_once("]_")?;
        Some((self.all.entry(number.parse().ok()?).or_default(), what))
    }

    /// Returns slope and intercept from the raw values, whose number is `raw`; or the reason why there is no linear scale.
    pub(super) fn line(&self, raw: Option<u32>) -> Result<[f64; 2], String> {
        let (mut slope, mut intercept) = (1.0, 0.0);
        let mut at = self.count.checked_sub(1).filter(|_| !self.scaled);
        while let Some(number) = at.filter(|number| Some(*number) != raw) {
            let none = format!("contains raw values without their scale {number}");
            let scale = self.all.get(&number).ok_or(none)?;
            let Some(own) = scale.slope.filter(|_| scale.kind == "Linear") else {
                return Err(format!("contains raw values with a scale of the kind {:?}, not a linear one", scale.kind));
            };
            (slope, intercept) = (slope * own, slope * scale.intercept + intercept);
            at = Some(scale.input).filter(|input| *input < RAW).map(|input| input as u32);
            // A scale may only use one before it: else there would be no end.
            if at.is_some_and(|input| input >= number) {
                return Err(format!("contains raw values whose scale {number} takes a later one for its input"));
            }
        }
        Ok([slope, intercept])
    }
}
