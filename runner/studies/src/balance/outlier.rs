//! Records that depart from the others of their condition: a knock at the machine, a lost pulse of the keyphasor, a gain that was changed.
//!
//! A record `y` of `n` at one condition and speed departs from the mean `m` of the others by `d = y - m`. With the variance `s^2` of a record about its mean, from all
//! others with `v` degrees of freedom, the ratio `x = |d|^2 (n - 1) / (n s^2)` of complex normal values exceeds a value by chance with the
//! probability `(1 + x / v)^-v` (F distribution with 2 and 2 `v` degrees of freedom).

use super::table::{C, VectorTable};
use serde::Serialize;
use std::collections::BTreeMap;

/// Probability that any record of a table is left out by chance.
const BY_CHANCE: f64 = 1e-3;
/// Records of a condition from which on one departs from the others, and not the others from it.
const LEAST: usize = 3;

/// A record that is not used.
#[derive(Debug, Clone, Serialize)]
pub struct Outlier {
    /// Condition.
    pub condition: String,
    /// Number among the records of the condition in the order of the table, from 1.
    pub record: usize,
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Probe at which it departs most.
    pub probe: String,
    /// Distance from the mean of the others.
    pub distance: f64,
    /// Standard deviation of such a distance.
    pub deviation: f64,
}

/// Returns a table without the records that depart from the others of their condition, and these, the clearest first.
pub(super) fn without_outliers(table: &VectorTable) -> (VectorTable, Vec<Outlier>) {
    let numbers = numbers(table);
    let mut left: Vec<usize> = (0..table.records.len()).collect();
    let mut outliers = vec![];
    while let Some((at, outlier)) = clearest(table, &left, &numbers) {
        left.retain(|record| *record != at);
        outliers.push(outlier);
    }
    let records = left.iter().map(|&record| table.records[record].clone()).collect();
    (VectorTable { records, ..table.clone() }, outliers)
}

/// Returns the number of each record in its condition, from 1.
fn numbers(table: &VectorTable) -> Vec<usize> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let number = |condition| {
        let count = counts.entry(condition).or_default();
        *count += 1;
        *count
    };
    table.records.iter().map(|record| record.condition.as_str()).map(number).collect()
}

/// Returns the record that departs most from the others of its condition, if that is not by chance.
fn clearest(table: &VectorTable, left: &[usize], numbers: &[usize]) -> Option<(usize, Outlier)> {
    let (speeds, _) = table.speeds();
    let mut runs: BTreeMap<(&str, usize), Vec<usize>> = BTreeMap::new();
    for &record in left {
        runs.entry((table.records[record].condition.as_str(), speeds[record])).or_default().push(record);
    }
    let response = |record: usize, probe: usize| table.records[record].response[probe];
    let mut best: Option<(f64, usize, Outlier)> = None;
    for probe in 0..table.probes.len() {
        let mean = |of: &[usize]| of.iter().map(|&record| response(record, probe)).sum::<C>() / of.len() as f64;
        // Sum of the squares about the means, and its degrees of freedom, of each speed.
        let mut sums: BTreeMap<usize, (f64, usize)> = BTreeMap::new();
        for ((_, speed), of) in &runs {
            let mean = mean(of);
            let (sum, freedom) = sums.entry(*speed).or_default();
            *sum += of.iter().map(|&record| (response(record, probe) - mean).norm_sqr()).sum::<f64>();
            *freedom += of.len() - 1;
        }
        for ((condition, speed), of) in runs.iter().filter(|(_, of)| of.len() >= LEAST) {
            let (n, mean, (sum, freedom)) = (of.len() as f64, mean(of), sums[speed]);
            let freedom = (freedom - 1) as f64;
            for &record in of {
                let distance = (response(record, probe) - mean).norm() * n / (n - 1.0);
                let own = distance * distance * (n - 1.0) / n;
                let variance = (sum - own).max(f64::EPSILON * sum) / freedom;
                let by_chance = (1.0 + own / (variance * freedom)).powf(-freedom);
                if variance > 0.0 && best.as_ref().is_none_or(|(least, ..)| by_chance < *least) {
                    let outlier = Outlier {
                        condition: (*condition).to_owned(),
                        record: numbers[record],
                        speed_rpm: table.records[record].speed,
                        probe: table.probes[probe].clone(),
                        distance,
                        deviation: (variance * n / (n - 1.0)).sqrt(),
                    };
                    best = Some((by_chance, record, outlier));
                }
            }
        }
    }
    let compared = (left.len() * table.probes.len()) as f64;
    best.filter(|(by_chance, ..)| by_chance * compared < BY_CHANCE).map(|(_, record, outlier)| (record, outlier))
}

#[cfg(test)]
mod tests {
    use super::super::table::{Record, Set};
    use super::*;

    /// A table of two conditions with so many records each, two probes, and errors of 1.
    fn table(records: usize, seed: u64) -> VectorTable {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut uniform = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            ((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        let mut vector = || C::from_polar((-uniform().ln()).sqrt(), std::f64::consts::TAU * uniform());
        let record = |condition: &str, vector: &mut dyn FnMut() -> C| Record {
            condition: condition.to_owned(),
            set: Set::Baseline,
            speed: 3000.0,
            moments: Some(vec![C::new(0.0, 0.0)]),
            response: vec![C::new(30.0, -20.0) + vector(), C::new(5.0, 40.0) + vector()],
            time: None,
        };
        let records = ["a", "b"]
            .iter()
            .flat_map(|name| (0..records).map(|_| *name))
            .map(|name| record(name, &mut vector))
            .collect();
        VectorTable {
            planes: vec!["fan".to_owned()],
            probes: vec!["x".to_owned(), "y".to_owned()],
            unit: "um".to_owned(),
            records,
            has_run_ups: false,
        }
    }

    /// Of 2000 tables without an outlier, at most some lose a record; one that departs by ten deviations is left out of all.
    #[test]
    fn a_record_is_left_out_seldom_by_chance() {
        for records in [3, 6] {
            let by_chance = (1..=2000).filter(|seed| !without_outliers(&table(records, *seed)).1.is_empty()).count();
            // Ten are beyond three deviations of the two expected.
            assert!(by_chance < 10, "{records}: {by_chance}");
        }
        for seed in 1..=200 {
            let mut table = table(8, seed);
            table.records[11].response[1] += C::new(10.0, 10.0);
            let (left, outliers) = without_outliers(&table);
            assert_eq!(left.records.len(), 15, "{seed}");
            let of = |outlier: &Outlier| (outlier.condition.clone(), outlier.record, outlier.probe.clone());
            assert_eq!(outliers.iter().map(of).collect::<Vec<_>>(), [("b".to_owned(), 4, "y".to_owned())]);
        }
    }

    /// Of two records, nothing tells which one departs.
    #[test]
    fn two_records_are_both_used() {
        let mut table = table(2, 1);
        table.records[0].response[0] += C::new(1e6, 0.0);
        assert!(without_outliers(&table).1.is_empty());
    }
}
