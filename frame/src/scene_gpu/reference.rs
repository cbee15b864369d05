//! The CPU half of `mesh_point`, `material_lookup` and `material_surface`: the same steps on [`scene::Material`] itself,
//! at mip 0 (a footprint of area 0).

use super::texels::Encoding;
use crate::cpu;
use crate::surface::{Surface, linear_from_srgb};
use glam::{Mat2, Vec2, Vec3, Vec4, Vec4Swizzles};
use scene::{Alpha, Geometry, Image, Material, Scene, TextureSlot, Wrap};

/// A point of a triangle, interpolated.
#[derive(Clone, Copy, Debug)]
pub struct MeshPoint {
    /// Metres.
    pub position: Vec3,
    /// Unit, on the front side.
    pub face_normal: Vec3,
    /// Unit.
    pub normal: Vec3,
    /// As interpolated.
    pub tangent: Vec4,
    /// First and second texture coordinates.
    pub uv: [Vec2; 2],
    /// Linear RGBA.
    pub color: Vec4,
}

/// `weights` are those of the second and third corner.
pub fn mesh_point(geometry: &Geometry, triangle: usize, weights: Vec2) -> MeshPoint {
    let [a, b, c] = geometry.triangles[triangle].vertices.map(|v| v as usize);
    let share = [1.0 - weights.x - weights.y, weights.x, weights.y];
    let mix3 = |list: &[Vec3]| share[0] * list[a] + share[1] * list[b] + share[2] * list[c];
    let mix4 = |list: &[Vec4]| share[0] * list[a] + share[1] * list[b] + share[2] * list[c];
    let mix2 = |list: &[Vec2]| match list.is_empty() {
        true => Vec2::ZERO,
        false => share[0] * list[a] + share[1] * list[b] + share[2] * list[c],
    };
    let p = [a, b, c].map(|v| geometry.positions[v].as_dvec3());
    let normal = mix3(&geometry.normals);
    let face_normal = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize().map_or(normal, |n| n.as_vec3());
    MeshPoint {
        position: mix3(&geometry.positions),
        face_normal,
        normal: normal.try_normalize().unwrap_or(face_normal),
        tangent: mix4(&geometry.tangents).xyz().extend(geometry.tangents[a].w),
        uv: [mix2(&geometry.uv0), mix2(&geometry.uv1)],
        color: if geometry.colors.is_empty() { Vec4::ONE } else { mix4(&geometry.colors) },
    }
}

fn wrap(i: i64, size: i64, mode: Wrap) -> i64 {
    match mode {
        Wrap::Repeat => i.rem_euclid(size),
        Wrap::Mirror => {
            let folded = i.rem_euclid(2 * size);
            if folded < size { folded } else { 2 * size - 1 - folded }
        }
        Wrap::Clamp => i.clamp(0, size - 1),
    }
}

/// A slot's texture at mip 0: bilinear, or the nearest texel if asked for here or by the slot.
pub fn lookup(image: &Image, slot: &TextureSlot, encoding: Encoding, uv: [Vec2; 2], nearest: bool) -> Vec4 {
    let uv = slot.uv_transform.transform_point2(uv[slot.uv_set.min(1) as usize]);
    let size = [i64::from(image.width), i64::from(image.height)];
    let texel = |x: i64, y: i64| {
        let (x, y) = (wrap(x, size[0], slot.wrap[0]), wrap(y, size[1], slot.wrap[1]));
        let codes = Vec4::from(image.rgba[(y * size[0] + x) as usize].map(f32::from)) / 255.0;
        match encoding {
            Encoding::Srgb => codes.xyz().map(linear_from_srgb).extend(codes.w),
            Encoding::Linear => codes,
        }
    };
    let is_point = nearest || !slot.linear;
    let at = uv * Vec2::new(size[0] as f32, size[1] as f32) - if is_point { 0.0 } else { 0.5 };
    let low = at.floor();
    let (x, y) = (low.x as i64, low.y as i64);
    if is_point {
        return texel(x, y);
    }
    let w = at - low;
    let row = |y: i64| texel(x, y).lerp(texel(x + 1, y), w.x);
    row(y).lerp(row(y + 1), w.y)
}

fn read(
    scene: &Scene,
    slot: Option<TextureSlot>,
    encoding: Encoding,
    point: &MeshPoint,
    nearest: bool,
) -> Vec4 {
    let image = slot.and_then(|slot| scene.images.get(slot.image as usize).map(|image| (image, slot)));
    image.map_or(Vec4::ONE, |(image, slot)| lookup(image, &slot, encoding, point.uv, nearest))
}

/// 1 where there is something, 0 in the hole of a mask, the alpha of a blend.
pub fn opacity(scene: &Scene, material: usize, point: &MeshPoint) -> f32 {
    let m = &scene.materials[material];
    let is_mask = matches!(m.alpha, Alpha::Mask(_));
    let alpha =
        m.base_color.w * point.color.w * read(scene, m.base_color_texture, Encoding::Srgb, point, is_mask).w;
    match m.alpha {
        Alpha::Opaque => 1.0,
        Alpha::Mask(cutoff) => f32::from(u8::from(alpha >= cutoff)),
        Alpha::Blend => alpha,
    }
}

/// What the point is made of, its normal on the front side.
pub fn surface(scene: &Scene, material: usize, point: &MeshPoint, radiance_scale: f32) -> Surface {
    let m = &scene.materials[material];
    let linear = |slot| read(scene, slot, Encoding::Linear, point, false);
    let color = |slot| read(scene, slot, Encoding::Srgb, point, false).xyz();
    let base = m.base_color.xyz() * point.color.xyz() * color(m.base_color_texture);
    let emission = m.emission * color(m.emission_texture);
    let metallic_roughness = linear(m.metallic_roughness_texture);
    let roughness = m.roughness * metallic_roughness.y;

    let tangent = perpendicular(point.tangent.xyz(), point.normal);
    let bitangent = point.normal.cross(tangent) * point.tangent.w;
    let mut normal = point.normal;
    if m.normal_texture.is_some() {
        let mapped = 2.0 * linear(m.normal_texture).xyz() - 1.0;
        let bent = m.normal_scale * (mapped.x * tangent + mapped.y * bitangent) + mapped.z * point.normal;
        normal = bent.try_normalize().unwrap_or(normal);
    }
    let (mut along, mut strength) = (Vec2::X, m.anisotropy);
    if m.anisotropy > 0.0 && m.anisotropy_texture.is_some() {
        let texel = linear(m.anisotropy_texture);
        along = 2.0 * texel.xy() - 1.0;
        strength *= texel.z;
    }
    if m.anisotropy > 0.0 {
        along = Mat2::from_angle(m.anisotropy_rotation) * along;
    }
    let alpha = roughness * roughness;
    let alpha_tangent = alpha + (1.0 - alpha) * strength * strength;

    let transmission = m.transmission * linear(m.transmission_texture).x;
    let mut s = Surface {
        normal,
        tangent: perpendicular(along.x * tangent + along.y * bitangent, normal),
        handedness: point.tangent.w,
        base,
        metalness: m.metallic * metallic_roughness.z,
        emission: radiance_scale * emission,
        absorption: m.volume.filter(|_| m.transmission > 0.0).map(|v| v.absorption()).unwrap_or_default(),
        roughness: Vec2::new(alpha_tangent.sqrt(), roughness),
        f0: f0(scene, m, point),
        transmission,
        coverage: opacity(scene, material, point),
        contour: 0.0,
        two_sided: m.double_sided,
        thin: m.transmission > 0.0 && m.volume.is_none(),
    };
    if m.unlit {
        s = Surface {
            normal: point.normal,
            tangent: perpendicular(tangent, point.normal),
            handedness: s.handedness,
            base: Vec3::ZERO,
            emission: radiance_scale * base,
            coverage: s.coverage,
            two_sided: s.two_sided,
            ..Surface::default()
        };
    }
    s
}

fn f0(scene: &Scene, m: &Material, point: &MeshPoint) -> f32 {
    let root = (m.ior - 1.0) / (m.ior + 1.0);
    if m.transmission > 0.0 {
        return root * root;
    }
    let strength = m.specular * read(scene, m.specular_texture, Encoding::Linear, point, false).w;
    let tint = read(scene, m.specular_color_texture, Encoding::Srgb, point, false).xyz();
    let factor = cpu::luminance(m.specular_color.to_array());
    (root * root * strength * factor).min(1.0) * cpu::luminance(tint.to_array())
}

fn perpendicular(v: Vec3, normal: Vec3) -> Vec3 {
    let across = v.reject_from_normalized(normal);
    let axis = if normal.x.abs() > 0.7 { Vec3::Y } else { Vec3::X };
    across.try_normalize().unwrap_or_else(|| axis.cross(normal).normalize())
}

/// A surface as seen from behind: nothing emitted, the tangent frame turned over.
pub fn turn(surface: &Surface) -> Surface {
    Surface { normal: -surface.normal, handedness: -surface.handedness, emission: Vec3::ZERO, ..*surface }
}

/// A normal that faces `wo`.
pub fn bend(normal: Vec3, wo: Vec3) -> Vec3 {
    const LEAST_COSINE: f32 = 0.01;
    let cosine = normal.dot(wo);
    if cosine >= LEAST_COSINE {
        return normal;
    }
    (normal + (LEAST_COSINE - cosine) * wo).normalize()
}
