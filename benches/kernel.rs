//! Every subject under Criterion: `cargo bench -p ballrace-benches --bench kernel`, with a filter if wanted.

mod subjects;

use ballrace::bearing::geometry::InvalidParameter;
use criterion::{Bencher, Criterion};
use std::time::{Duration, Instant};
use subjects::Subject;

fn main() -> Result<(), InvalidParameter> {
    let limits = Criterion::default().warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    let mut criterion = limits.configure_from_args();
    for mut subject in subjects::all()? {
        let id = format!("{}/{}", subject.row, subject.column);
        criterion.bench_function(&id, |bencher| time(bencher, &mut subject));
    }
    criterion.final_summary();
    Ok(())
}

/// A run makes many calls; what Criterion prints is the time of one.
fn time(bencher: &mut Bencher, subject: &mut Subject) {
    bencher.iter_custom(|calls| {
        let runs = calls.div_ceil(u64::from(subject.calls));
        let start = Instant::now();
        for _ in 0..runs {
            (subject.run)();
        }
        start.elapsed().mul_f64(calls as f64 / (runs * u64::from(subject.calls)) as f64)
    });
}
