//! `KHR_materials_pbrSpecularGlossiness` as metallic-roughness: some older files require it.
//!
//! A surface with diffuse colour d and specular colour s is taken for a mix of a dielectric with F0 = 0.04 and a
//! metal. The metallic share m keeps the perceived brightness of both: with b(c) = sqrt(0.299 r^2 + 0.587 g^2 +
//! 0.114 b^2) it solves `0.04 m^2 + (b(d) (1 - max s) / 0.96 + b(s) - 0.08) m + 0.04 - b(s) = 0`, the conversion that
//! the extension's authors published. Roughness is 1 - glossiness.

use super::materials::{number, share};
use crate::Material;
use glam::{Vec3, Vec4};
use serde_json::Value;

const DIELECTRIC: f32 = 0.04;

/// Overwrites base colour, metalness and roughness.
pub(super) fn convert(m: &mut Material, file: &Value) {
    let diffuse = Vec4::from(factors(file, "diffuseFactor"));
    let [r, g, b, _] = factors(file, "specularFactor");
    let (d, s) = (diffuse.truncate(), Vec3::new(r, g, b));
    let rest = 1.0 - s.max_element();
    let metallic = metallic(brightness(d), brightness(s), rest);
    let from_diffuse = d * (rest / (1.0 - DIELECTRIC) / (1.0 - metallic).max(1e-6));
    let from_specular = (s - DIELECTRIC * (1.0 - metallic)) / metallic.max(1e-6);
    let base = from_diffuse.lerp(from_specular, metallic * metallic);
    m.base_color = base.clamp(Vec3::ZERO, Vec3::ONE).extend(diffuse.w);
    m.metallic = metallic;
    m.roughness = 1.0 - share(number(file, "glossinessFactor", 1.0), 1.0);
}

fn metallic(diffuse: f32, specular: f32, rest: f32) -> f32 {
    if specular < DIELECTRIC {
        return 0.0;
    }
    let (a, b, c) = (
        DIELECTRIC,
        diffuse * rest / (1.0 - DIELECTRIC) + specular - 2.0 * DIELECTRIC,
        DIELECTRIC - specular,
    );
    ((-b + (b * b - 4.0 * a * c).max(0.0).sqrt()) / (2.0 * a)).clamp(0.0, 1.0)
}

fn brightness(c: Vec3) -> f32 {
    (c * c).dot(Vec3::new(0.299, 0.587, 0.114)).sqrt()
}

/// Up to four numbers, 1 where the file has none.
fn factors(file: &Value, key: &str) -> [f32; 4] {
    let list = file.get(key).and_then(Value::as_array);
    std::array::from_fn(|i| {
        let x = list.and_then(|list| list.get(i)).and_then(Value::as_f64);
        share(x.map_or(1.0, |x| x as f32), 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn pure_metals_and_pure_dielectrics_come_out_as_such() {
        let mut m = Material::default();
        convert(
            &mut m,
            &json!({"diffuseFactor": [0, 0, 0, 1], "specularFactor": [1.0, 0.8, 0.3], "glossinessFactor": 0.75}),
        );
        // 1e-3: the quadratic is solved in f32.
        assert!((m.metallic - 1.0).abs() < 1e-3 && m.roughness == 0.25, "{m:?}");
        assert!(m.base_color.abs_diff_eq(Vec4::new(1.0, 0.8, 0.3, 1.0), 1e-3), "{m:?}");
        convert(
            &mut m,
            &json!({"diffuseFactor": [0.5, 0.25, 0.1, 0.5], "specularFactor": [0.04, 0.04, 0.04]}),
        );
        assert!(m.metallic < 1e-3 && m.roughness == 0.0, "{m:?}");
        assert!(m.base_color.abs_diff_eq(Vec4::new(0.5, 0.25, 0.1, 0.5), 1e-3), "{m:?}");
    }
}
