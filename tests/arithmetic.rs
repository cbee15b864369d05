//! Does each numeric routine err as little as its table says? The worst case over the whole domain, found anew each time.
//!
//! Measured are the CPU twins, which the shaders are compared with bit for bit or to a stated rounding by the unit tests
//! of their own crates. `docs/arithmetic.md` has a row per routine; its figure must be met, and not be more than twice
//! what is found, so that the table stays true in both directions.

use frame::surface::{
    face_normal_pack, face_normal_unpack, linear_from_srgb, normal_pack, normal_unpack, rgb9e5_pack,
    rgb9e5_unpack, srgb_from_linear, tangent_pack, tangent_unpack,
};
use glam::{DVec3, Vec3};
use std::f64::consts::TAU;
use std::path::Path;

/// The worst of many cases and where it was.
struct Worst {
    error: f64,
    place: String,
}

impl Worst {
    fn of(cases: impl IntoIterator<Item = (f64, String)>) -> Self {
        let none = Self { error: 0.0, place: "nowhere".into() };
        cases.into_iter().fold(none, |worst, (error, place)| match error > worst.error || error.is_nan() {
            true => Self { error, place },
            false => worst,
        })
    }
}

/// Directions all over the sphere, evenly (a Fibonacci spiral), and the axes and diagonals where codes fold.
fn directions(count: u32) -> impl Iterator<Item = Vec3> {
    let spiral = (0..count).map(move |i| {
        let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(count);
        let turn = TAU * (f64::from(i) * 0.618_033_988_749_894_9).fract();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * turn.cos(), r * turn.sin(), z).as_vec3()
    });
    let corners = (0..27)
        .filter(|i| *i != 13)
        .map(|i| Vec3::new((i % 3 - 1) as f32, (i / 3 % 3 - 1) as f32, (i / 9 - 1) as f32).normalize());
    spiral.chain(corners)
}

/// Radians between a direction and another that is nearly it: of the chord, for a cosine says nothing this close.
fn angle(a: Vec3, b: Vec3) -> f64 {
    let chord = (a.as_dvec3().normalize() - b.as_dvec3().normalize()).length();
    2.0 * (0.5 * chord).asin()
}

fn normals() -> Worst {
    Worst::of(directions(1 << 18).map(|n| (angle(n, normal_unpack(normal_pack(n))), n.to_string())))
}

fn face_normals() -> Worst {
    Worst::of(directions(1 << 18).map(|n| (angle(n, face_normal_unpack(face_normal_pack(n))), n.to_string())))
}

/// Tangents across the coded normal, at angles that no code has.
fn tangents() -> Worst {
    let cases = directions(1 << 12).flat_map(|n| {
        let code = normal_pack(n);
        let across = normal_unpack(code).any_orthonormal_pair();
        (0..61).map(move |i| {
            let turn = f32::from(i as u8) * 0.103;
            let tangent = turn.cos() * across.0 + turn.sin() * across.1;
            let word = code | tangent_pack(code, tangent, 1.0) << 24;
            (angle(tangent, tangent_unpack(word)), format!("{n} at {turn}"))
        })
    });
    Worst::of(cases)
}

/// Relative to the largest channel, which shares its exponent with the others; from the least that has a full mantissa to
/// the most.
fn emission() -> Worst {
    let cases = (0..1 << 18).map(|i| {
        let largest = 2f64.powf(-15.0 + 30.99 * f64::from(i) / f64::from(1 << 18)) as f32;
        let color = largest * Vec3::new(1.0, 0.37, 0.004 * (i % 200) as f32 % 1.0);
        let back = rgb9e5_unpack(rgb9e5_pack(color));
        let error = (back.as_dvec3() - color.as_dvec3()).abs().max_element() / f64::from(largest);
        (error, color.to_string())
    });
    Worst::of(cases)
}

fn srgb(x: f64) -> f64 {
    if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

fn linear(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// Spacing of floats at a value.
fn ulp(x: f64) -> f64 {
    let x = (x.abs() as f32).max(f32::MIN_POSITIVE);
    f64::from(x.next_up()) - f64::from(x)
}

fn to_srgb() -> Worst {
    let cases = (1..=1 << 18).map(|i| {
        let x = i as f32 / (1 << 18) as f32;
        let wanted = srgb(f64::from(x));
        ((f64::from(srgb_from_linear(x)) - wanted).abs() / ulp(wanted), x.to_string())
    });
    Worst::of(cases)
}

fn from_srgb() -> Worst {
    let cases = (1..=1 << 18).map(|i| {
        let x = i as f32 / (1 << 18) as f32;
        let wanted = linear(f64::from(x));
        ((f64::from(linear_from_srgb(x)) - wanted).abs() / ulp(wanted), x.to_string())
    });
    Worst::of(cases)
}

/// Name as in the table, unit, what is found.
fn all() -> [(&'static str, &'static str, Worst); 6] {
    [
        ("normal, 12 + 12 bits", "rad", normals()),
        ("face normal, 16 + 16 bits", "rad", face_normals()),
        ("tangent, 7 bits", "rad", tangents()),
        ("emission, RGB9E5", "of the largest channel", emission()),
        ("sRGB from linear", "ulp", to_srgb()),
        ("linear from sRGB", "ulp", from_srgb()),
    ]
}

/// The figure of a routine in the table.
fn told(table: &str, name: &str, unit: &str) -> f64 {
    let row = table.lines().find(|line| line.starts_with(&format!("| {name} |")));
    let cells: Vec<&str> =
        row.unwrap_or_else(|| panic!("no row for {name}")).split('|').map(str::trim).collect();
    let (figure, found_unit) = cells[2].split_once(' ').unwrap_or_else(|| panic!("{name}: {}", cells[2]));
    assert_eq!(found_unit, unit, "{name}");
    figure.parse().unwrap_or_else(|e| panic!("{name}: {figure}: {e}"))
}

#[test]
fn no_routine_errs_more_than_its_table_says() {
    let table =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/arithmetic.md")).unwrap();
    let mut wrong = Vec::new();
    for (name, unit, worst) in all() {
        println!("{name}: {:.4e} {unit} at {}", worst.error, worst.place);
        let told = told(&table, name, unit);
        if !(worst.error <= told && worst.error >= 0.5 * told) {
            wrong.push(format!("{name}: {:.4e} {unit} at {}, told {told}", worst.error, worst.place));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
