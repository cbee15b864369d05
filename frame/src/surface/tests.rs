#![allow(clippy::unwrap_used, clippy::panic)]

mod gpu;

use super::reference::{
    FACE_NORMAL_STEPS, NORMAL_STEPS, amount_pack, base_pack, base_unpack, basis, oct_unpack,
};
use super::*;
use glam::{DVec3, IVec2, Vec2, Vec3};

/// A stream of numbers in [0, 1).
struct Random(u32);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 += 2;
        // Two hashes, so that f64 comparisons see more than the 32 bits the codes hold.
        (f64::from(hash(self.0)) + f64::from(hash(self.0 ^ 0xffff_0001)) / 2f64.powi(32)) / 2f64.powi(32)
    }

    fn direction(&mut self) -> DVec3 {
        let z = 2.0 * self.next() - 1.0;
        let (sin, cos) = (std::f64::consts::TAU * self.next()).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * cos, radius * sin, z)
    }

    /// A normal and a tangent across it; three quarters lie on the equator, at a pole or along an axis.
    fn frame(&mut self, index: u32) -> (DVec3, DVec3) {
        let mut n = self.direction();
        match index % 8 {
            0 | 1 => n.z *= 1e-4,
            2 | 3 => n = DVec3::new(n.x * 1e-3, n.y * 1e-3, n.z.signum()),
            4 => n = DVec3::AXES[index as usize / 8 % 3] * n.x.signum() + n * 1e-9,
            _ => {}
        }
        let n = n.normalize();
        let across = n.cross(self.direction()).normalize();
        (n, across)
    }

    fn surface(&mut self) -> Surface {
        let (n, t) = self.frame(7);
        let mut number = || self.next() as f32;
        let mut surface = Surface {
            normal: n.as_vec3(),
            tangent: t.as_vec3(),
            handedness: if number() < 0.5 { 1.0 } else { -1.0 },
            base: Vec3::new(number(), number(), number()),
            metalness: number(),
            emission: Vec3::new(number(), number(), number()) * 100.0,
            absorption: Vec3::new(number(), number(), number()) * 10.0,
            roughness: Vec2::new(number(), number()),
            f0: number(),
            transmission: number(),
            coverage: number(),
            contour: number() - 0.5,
            two_sided: number() < 0.5,
            thin: number() < 0.5,
        };
        if number() < 0.7 {
            surface.emission = Vec3::ZERO;
        }
        surface
    }
}

/// What a degenerate triangle may give.
fn undefined() -> Surface {
    Surface {
        normal: Vec3::NAN,
        tangent: Vec3::NAN,
        base: Vec3::NAN,
        metalness: f32::NAN,
        emission: Vec3::NAN,
        absorption: Vec3::NAN,
        roughness: Vec2::NAN,
        f0: f32::NAN,
        transmission: f32::NAN,
        contour: f32::NAN,
        ..Surface::default()
    }
}

fn degrees(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// Mean, root mean square and maximum.
fn spread(errors: &[f64]) -> [f64; 3] {
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / count).sqrt();
    [mean, rms, errors.iter().copied().fold(0.0, f64::max)]
}

fn assert_spread(name: &str, errors: &[f64], bound: [f64; 3]) {
    let found = spread(errors);
    println!("{name}: mean {:.5} rms {:.5} max {:.5} degrees", found[0], found[1], found[2]);
    // The bounds are measured figures with three digits; 1 % covers the last one and the sample's own spread.
    for (found, bound) in found.into_iter().zip(bound) {
        assert!(found <= 1.01 * bound, "{name}: {found} above {bound}");
    }
}

#[test]
fn normals_lose_as_little_as_the_table_says() {
    let mut random = Random(1);
    let directions: Vec<DVec3> = (0..300_000).map(|_| random.direction()).collect();
    let error = |unpack: &dyn Fn(Vec3) -> Vec3| -> Vec<f64> {
        directions.iter().map(|&n| degrees(n, unpack(n.as_vec3()).as_dvec3())).collect()
    };
    assert_spread("12 + 12", &error(&|n| normal_unpack(normal_pack(n))), [0.0209, 0.0230, 0.0589]);
    let face = error(&|n| face_normal_unpack(face_normal_pack(n)));
    assert_spread("16 + 16", &face, [0.00131, 0.00144, 0.00368]);
}

#[test]
fn tangents_lose_as_little_as_the_table_says_in_hard_places_too() {
    let mut random = Random(2);
    let (mut tangents, mut bitangents) = (Vec::new(), Vec::new());
    for index in 0..300_000 {
        let (n, t) = random.frame(index);
        let handedness = if index & 1 == 0 { 1.0 } else { -1.0 };
        let surface = Surface { normal: n.as_vec3(), tangent: t.as_vec3(), handedness, ..Surface::default() };
        let back = Surface::unpack_voxel(surface.pack_voxel(0));
        assert_eq!(back.handedness, handedness);
        tangents.push(degrees(t, back.tangent.as_dvec3()));
        bitangents.push(degrees(n.cross(t) * f64::from(handedness), back.bitangent().as_dvec3()));
        assert!(back.tangent.dot(back.normal).abs() < 5e-7, "five roundings of f32");
    }
    assert_spread("tangent", &tangents, [0.704, 0.812, 1.407]);
    assert_spread("bitangent", &bitangents, [0.704, 0.812, 1.407]);
}

#[test]
fn every_normal_code_comes_back() {
    let mut pairs = 0;
    for y in -NORMAL_STEPS..=NORMAL_STEPS {
        for x in -NORMAL_STEPS..=NORMAL_STEPS {
            let code = (x as u32 & 0xfff) | ((y as u32 & 0xfff) << 12);
            let again = normal_pack(normal_unpack(code));
            if again != code {
                // Only the square's border has two codes for a direction; the other one is then final.
                assert!(x.abs() == NORMAL_STEPS || y.abs() == NORMAL_STEPS, "({x}, {y})");
                assert_eq!(normal_unpack(again), normal_unpack(code), "({x}, {y})");
                assert_eq!(normal_pack(normal_unpack(again)), again, "({x}, {y})");
                pairs += 1;
            }
        }
    }
    // The negative half of each of the four sides; the corner (-, -) is in two halves.
    assert_eq!(pairs, 4 * 2047 - 1);
    for x in (-FACE_NORMAL_STEPS..FACE_NORMAL_STEPS).step_by(37) {
        for y in (-FACE_NORMAL_STEPS + 1..FACE_NORMAL_STEPS).step_by(1013) {
            let code = (x as u32 & 0xffff) | ((y as u32) << 16);
            let again = face_normal_pack(face_normal_unpack(code));
            assert!(again == code || x == -FACE_NORMAL_STEPS, "({x}, {y})");
        }
    }
}

#[test]
fn tangent_codes_on_the_seam_come_back() {
    let mut seam = 0;
    for x in -NORMAL_STEPS..=NORMAL_STEPS {
        let rest = NORMAL_STEPS - x.abs();
        let both = [rest, -rest];
        for &y in if rest == 0 { &both[..1] } else { &both[..] } {
            seam += 1;
            assert_eq!(oct_unpack(IVec2::new(x, y), NORMAL_STEPS).z, 0);
            let normal = (x as u32 & 0xfff) | ((y as u32 & 0xfff) << 12);
            assert_eq!(normal_pack(normal_unpack(normal)), normal, "({x}, {y})");
            for tangent in 0..256 {
                let handedness = if tangent < 128 { 1.0 } else { -1.0 };
                let vector = tangent_unpack(normal | (tangent << 24));
                assert_eq!(tangent_pack(normal, vector, handedness), tangent, "({x}, {y}) {tangent}");
            }
        }
    }
    assert_eq!(seam, 8188);
}

#[test]
fn tangent_codes_elsewhere_come_back_and_their_bases_are_orthonormal() {
    let mut random = Random(3);
    for index in 0..20_000 {
        let normal = normal_pack(random.frame(index).0.as_vec3());
        let [first, second] = basis(normal);
        let n = normal_unpack(normal);
        let dots =
            [first.dot(second), first.dot(n), second.dot(n), first.length() - 1.0, second.length() - 1.0];
        assert!(dots.iter().all(|d| d.abs() < 5e-7), "{dots:?}: a few roundings of f32");
        for angle in 0..128 {
            assert_eq!(tangent_pack(normal, tangent_unpack(normal | (angle << 24)), 1.0), angle);
        }
    }
}

#[test]
fn axes_are_exact_whatever_the_sign_of_zero() {
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            for zeros in [[0.0, 0.0], [-0.0, 0.0], [0.0, -0.0], [-0.0, -0.0f32]] {
                let mut n = [zeros[0]; 3];
                n[(axis + 1) % 3] = zeros[1];
                n[axis] = sign;
                let n = Vec3::from_array(n);
                assert_eq!(normal_unpack(normal_pack(n)), n);
                assert_eq!(normal_pack(n), normal_pack(n + 0.0), "-0 is 0");
                assert_eq!(face_normal_unpack(face_normal_pack(n)), n);
                assert_eq!(face_normal_pack(n), face_normal_pack(n + 0.0), "-0 is 0");
            }
        }
    }
}

#[test]
fn what_has_no_direction_gives_code_zero() {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for bad in bad.map(|x| Vec3::new(0.5, x, 0.0)).into_iter().chain([Vec3::ZERO, Vec3::NAN]) {
        assert_eq!(normal_pack(bad), 0, "{bad}");
        assert_eq!(face_normal_pack(bad), 0, "{bad}");
        assert_eq!(tangent_pack(normal_pack(Vec3::X), bad, 1.0), 0, "{bad}");
    }
    let mut random = Random(4);
    for _ in 0..1000 {
        let code = normal_pack(random.direction().as_vec3());
        let n = normal_unpack(code);
        assert_eq!(tangent_pack(code, n, 1.0), 0, "along the normal");
        assert_eq!(tangent_pack(code, -n, -1.0), 128, "against the normal");
        assert!(tangent_unpack(code).is_normalized());
    }
    assert_eq!(undefined().pack_voxel(5), [0; 4]);
    assert_eq!(undefined().pack_gbuffer(5), [0; 4]);
}

#[test]
fn shared_exponents_keep_their_bounds() {
    let mut random = Random(5);
    for _ in 0..300_000 {
        let scale = 2f64.powf(-14.0 + 29.9 * random.next());
        let c = Vec3::from_array([0; 3].map(|_| (random.next() * scale) as f32));
        let back = rgb9e5_unpack(rgb9e5_pack(c));
        let largest = c.max_element();
        // What is kept of the largest sets the step: just below a power of two it is rounded up to it.
        let half_step = (back.max_element() / 512.0).max(2f32.powi(-25));
        assert!((c - back).abs().max_element() <= half_step, "{c} {back}");
        if largest >= 2f32.powi(-16) {
            assert!((back.max_element() - largest).abs() <= largest * (0.5 / 256.0), "{c} {back}");
        }
        assert_eq!(rgb9e5_pack(back), rgb9e5_pack(rgb9e5_unpack(rgb9e5_pack(back))));
        assert_eq!(rgb9e5_unpack(rgb9e5_pack(back)), back);
    }
    let step = 2f32.powi(-24);
    for (given, kept) in [
        (Vec3::new(65408.0, 0.0, 1e9), Vec3::new(65408.0, 0.0, 65408.0)),
        (Vec3::new(f32::INFINITY, 1.0, 0.0), Vec3::new(65408.0, 0.0, 0.0)),
        (Vec3::new(f32::NAN, -1.0, 1.0), Vec3::new(0.0, 0.0, 1.0)),
        (Vec3::splat(-0.0), Vec3::ZERO),
        (Vec3::new(step, 3.0 * step, f32::MIN_POSITIVE), Vec3::new(step, 3.0 * step, 0.0)),
        // Rounds to 512 steps: the exponent has to grow.
        (Vec3::new(511.6, 0.0, 0.0), Vec3::new(512.0, 0.0, 0.0)),
    ] {
        assert_eq!(rgb9e5_unpack(rgb9e5_pack(given)), kept);
    }
}

#[test]
fn f0_codes_give_the_index_of_refraction() {
    let ior = |s: f64| (1.0 + s) / (1.0 - s);
    for index in 0..=1000 {
        let wanted = 1.0 + 1.5 * f64::from(index) / 1000.0;
        let s = (wanted - 1.0) / (wanted + 1.0);
        let surface = Surface { f0: (s * s) as f32, ..Surface::default() };
        let kept = Surface::unpack_voxel(surface.pack_voxel(0));
        let error = (ior(f64::from(kept.f0).sqrt()) - wanted).abs();
        // Half a code times the slope of the index over sqrt F0, at the code's far side; 1e-6 for f32.
        let slope = 2.0 / (1.0 - s - 0.5 / 255.0).powi(2);
        assert!(error <= slope * 0.5 / 255.0 + 1e-6, "{wanted}: {error}");
        if (wanted - 1.5).abs() < 1e-9 {
            assert!(error < 1e-6, "0.2 is code 51: {error}");
        }
    }
}

#[test]
fn rounded_colours_and_amounts_keep_their_mean() {
    const HASHES: u32 = 40_000;
    let mut random = Random(6);
    // Five standard errors of a coin at its worst, over one step. A step of sRGB is at most 2.4/255 + 10 %.
    let bound = |step: f64| 5.0 * 0.5 * step / f64::from(HASHES).sqrt();
    for index in 0..60 {
        let x = if index < 20 { f64::from(index) / 2000.0 } else { random.next() };
        let mut sum = [0.0; 2];
        for cell in 0..HASHES {
            let hash = hash(cell ^ (index << 20));
            let base = base_unpack(base_pack(Vec3::splat(x as f32), hash));
            assert!(base.x == base.y && base.y == base.z, "grey stays grey");
            sum[0] += f64::from(base.x);
            sum[1] += f64::from(amount_pack(x as f32, 0.0, 1.0, hash) >> 2) / 15.0;
        }
        let mean = sum.map(|s| s / f64::from(HASHES));
        assert!((mean[0] - x).abs() < bound(2.64 / 255.0), "{x}: {mean:?}");
        assert!((mean[1] - x).abs() < bound(1.0 / 15.0), "{x}: {mean:?}");
    }
}

#[test]
fn what_a_code_hits_exactly_is_not_rounded_at_random() {
    for cell in 0..200 {
        let hash = hash(cell);
        for code in 0..256u32 {
            let word = code * 0x01_01_01;
            assert_eq!(base_pack(base_unpack(word), hash), word);
        }
        for code in 1..16 {
            assert_eq!(amount_pack(code as f32 / 15.0, 0.0, 1.0, hash), 1 | (code << 2));
        }
    }
}

#[test]
fn records_come_back_bit_for_bit_under_any_hash() {
    let mut random = Random(7);
    for index in 0..50_000 {
        let surface = random.surface();
        let voxel = surface.pack_voxel(hash(index));
        assert_eq!(Surface::unpack_voxel(voxel).pack_voxel(hash(!index)), voxel, "{surface:?}");
        let texel = surface.pack_gbuffer(hash(index));
        assert_eq!(Surface::unpack_gbuffer(texel).pack_gbuffer(hash(!index)), texel, "{surface:?}");
    }
}

#[test]
fn the_largest_share_is_the_one_kept() {
    let plain = Surface::default();
    let keep = |s: Surface| {
        let s = Surface::unpack_voxel(s.pack_voxel(9));
        (s.metalness, s.transmission, s.coverage)
    };
    assert_eq!(keep(plain), (0.0, 0.0, 1.0));
    assert_eq!(keep(Surface { metalness: 0.8, transmission: 0.6, coverage: 0.6, ..plain }), (0.8, 0.0, 1.0));
    assert_eq!(keep(Surface { metalness: 0.2, transmission: 0.6, coverage: 0.6, ..plain }), (0.0, 0.6, 1.0));
    assert_eq!(keep(Surface { metalness: 0.2, transmission: 0.2, coverage: 0.6, ..plain }), (0.0, 0.0, 0.6));
    let texel = Surface { metalness: 1.0, transmission: 0.6, ..plain }.pack_gbuffer(9);
    let texel = Surface::unpack_gbuffer(texel);
    assert_eq!((texel.metalness, texel.transmission), (1.0, 0.6));
}

#[test]
fn a_solid_keeps_its_absorption_and_what_shines_its_emission() {
    let back = |s: Surface| {
        let s = Surface::unpack_voxel(s.pack_voxel(1));
        (s.emission, s.absorption, s.thin)
    };
    let both = Surface { emission: Vec3::X, absorption: Vec3::Y, ..Surface::default() };
    let clear = Surface { transmission: 1.0, ..both };
    assert_eq!(back(both), (Vec3::X, Vec3::ZERO, false));
    assert_eq!(back(Surface { emission: Vec3::ZERO, ..clear }), (Vec3::ZERO, Vec3::Y, false));
    assert_eq!(back(clear), (Vec3::X, Vec3::ZERO, true), "a thin sheet that shines");
}

#[test]
fn contours_are_kept_to_half_a_step() {
    let back =
        |contour| Surface::unpack_voxel(Surface { contour, ..Surface::default() }.pack_voxel(0)).contour;
    for index in -1000..=1000 {
        let offset = index as f32 / 1000.0 * 0.75f32.sqrt();
        // Half of sqrt(3)/2 over 127, and f32's rounding.
        assert!((back(offset) - offset).abs() < 0.003_411);
        assert_ne!(back(offset), CREASE);
    }
    assert_eq!(back(CREASE), CREASE);
}
