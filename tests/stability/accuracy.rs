//! The table of rounding errors in `docs/src/validation.md`, held from both sides: a figure that is exceeded fails, and so
//! does one that has become needlessly loose.

use super::models::{self, turning};
use ballrace::{Displacement, Exact, Fast, Math, Phase};
use ballrace_tests::states::Random;
use std::path::PathBuf;

const BEGIN: &str = "<!-- accuracy:begin -->\n";
const END: &str = "<!-- accuracy:end -->";
/// A figure may be this much larger than what is measured.
const LOOSE: f64 = 1.5;

struct Claim {
    what: String,
    error: f64,
}

/// Largest relative error over a sweep of arguments.
fn relative(count: u32, argument: impl Fn(f64) -> f64, found: impl Fn(f64) -> f64, right: impl Fn(f64) -> f64) -> f64 {
    let one = |i: u32| {
        let x = argument((f64::from(i) + 0.5) / f64::from(count));
        (found(x) / right(x) - 1.0).abs()
    };
    (0..count).map(one).fold(0.0, f64::max)
}

fn functions() -> Vec<Claim> {
    let count = 200_000;
    let decades = |a: f64, b: f64| move |part: f64| f64::from((a * (b / a).powf(part)) as f32);
    let sine = |turn: &dyn Fn(Phase) -> f64| {
        (0..count)
            .map(|i| {
                let turn_at = Phase(u64::from(i) * (u64::MAX / u64::from(count)));
                (turn(turn_at) - turn_at.radians().sin()).abs()
            })
            .fold(0.0, f64::max)
    };
    let claim = |what: &str, error: f64| Claim { what: what.to_owned(), error };
    vec![
        claim("sine of an angle, f32 (absolute)", sine(&|t| f64::from(<Exact as Math<f32>>::sin_cos(t).0))),
        claim("sine of an angle, f64 (absolute)", sine(&|t| <Exact as Math<f64>>::sin_cos(t).0)),
        claim(
            "square root, f32 Fast",
            relative(count, decades(1e-12, 1e12), |x| f64::from(<Fast as Math<f32>>::sqrt(x as f32)), f64::sqrt),
        ),
        claim(
            "power 1.4, f32",
            relative(
                count,
                decades(1e-9, 1e9),
                |x| f64::from(<Exact as Math<f32>>::powf(x as f32, 1.4)),
                |x| x.powf(f64::from(1.4_f32)),
            ),
        ),
        claim(
            "ninth root, f32",
            relative(
                count,
                decades(1e-9, 1e9),
                |x| f64::from(<Exact as Math<f32>>::ninth_root(x as f32)),
                |x| x.powf(1.0 / 9.0),
            ),
        ),
    ]
}

/// Largest difference of forces over the largest force, over poses of a running bearing.
fn forces() -> Vec<Claim> {
    let mut random = Random(0xacc0_0acc_1234_4321);
    let poses: Vec<(Displacement<f32>, Phase)> = (0..20_000)
        .map(|_| {
            let mut part = |most: f64| (random.between(-1.0, 1.0) * most) as f32;
            let u =
                Displacement { u: part(4e-6), v: part(4e-6), w: 10e-6 + part(4e-6), thu: part(1e-4), thv: part(1e-4) };
            (u, Phase::from_revolutions(random.unit()))
        })
        .collect();
    let right: Vec<_> = models::all::<f64, Exact>();
    let of = |label: &str, single: Vec<models::Named<f32>>| -> Vec<Claim> {
        let claim = |((name, bearing), (_, right)): (&models::Named<f32>, &models::Named<f64>)| {
            let (mut apart, mut largest) = (0.0_f64, 0.0_f64);
            for (u, cage) in &poses {
                let wide = Displacement::from_array(u.to_array().map(f64::from));
                let found = bearing.reaction(u, &turning(*cage)).wrench.to_array();
                let expected = right.reaction(&wide, &turning(*cage)).wrench.to_array();
                for (f, e) in found.iter().zip(expected).take(3) {
                    apart = apart.max((f64::from(*f) - e).abs());
                    largest = largest.max(e.abs());
                }
            }
            Claim { what: format!("force, {name}, {label}, over the largest force"), error: apart / largest }
        };
        single.iter().zip(&right).map(claim).collect()
    };
    let mut all = of("f32", models::all::<f32, Exact>());
    all.extend(of("f32 Fast", models::direct::<f32, Fast>()));
    // The table against what it was made from.
    let (table, solved) = (&right[9], &right[7]);
    assert_eq!((table.0, solved.0), ("tabulated", "quasi-static, inertia"));
    let (mut apart, mut largest) = (0.0_f64, 0.0_f64);
    for (u, cage) in &poses {
        let wide = Displacement::from_array(u.to_array().map(f64::from));
        let [found, expected] = [table, solved].map(|(_, b)| b.reaction(&wide, &turning(*cage)).wrench.to_array());
        for (f, e) in found.iter().zip(expected).take(3) {
            apart = apart.max((f - e).abs());
            largest = largest.max(e.abs());
        }
    }
    all.push(Claim {
        what: "force, tabulated 64 x 12 x 4, f64, against the model that it was made from".to_owned(),
        error: apart / largest,
    });
    all
}

/// The file that holds the table, from the root of the repository.
const CHAPTER: &str = "docs/src/validation.md";

fn chapter() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "..", CHAPTER].iter().collect()
}

/// Rounded up to two digits.
fn stated(error: f64) -> String {
    let power = 10_f64.powf(error.log10().floor() - 1.0);
    format!("{:.1e}", (error / power).ceil() * power)
}

#[test]
fn stated_errors_are_upper_bounds_within_a_factor() {
    let claims: Vec<Claim> = functions().into_iter().chain(forces()).filter(|c| c.error > 0.0).collect();
    let text = std::fs::read_to_string(chapter()).unwrap();
    let begin = text.find(BEGIN).expect("a mark where the table begins") + BEGIN.len();
    let end = text.find(END).expect("a mark where the table ends");
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        let rows: String = claims.iter().map(|c| format!("| {} | {} |\n", c.what, stated(c.error))).collect();
        let table = format!("| quantity | largest error |\n| --- | --: |\n{rows}");
        std::fs::write(chapter(), format!("{}{table}{}", &text[..begin], &text[end..])).unwrap();
        return;
    }
    let table = &text[begin..end];
    assert_eq!(table.lines().count(), claims.len() + 2, "BALLRACE_WRITE=1 rewrites the table");
    for Claim { what, error } in &claims {
        let row = table
            .lines()
            .find(|line| line.starts_with(&format!("| {what} |")))
            .unwrap_or_else(|| panic!("no row: {what}"));
        let most: f64 = row.split('|').nth(2).unwrap().trim().parse().unwrap();
        println!("{what}: {error:.2e}, stated {most:.1e}");
        assert!(*error <= most, "{what}: {error:e}, {CHAPTER} has {most:e}");
        assert!(*error * LOOSE >= most, "{what}: {error:e}, needlessly loose in {CHAPTER}: {most:e}");
    }
}
