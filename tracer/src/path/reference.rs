//! The CPU half: the same steps as the four shaders, in the same order. Positions, directions and random numbers are f32
//! as on the device, so that both walk through the same cells; light and probabilities are f64. Without samples of
//! emitters and the sky (`PathBuild::next_event`): those are tested against paths that find both by chance.

use super::{PASSES, PathParams, SampleRule};
use crate::lights::reference::{LightSample, light_sample};
use crate::noise;
use frame::brdf::{self, Brdf, BrdfTable};
use frame::info::Frame;
use frame::scene_gpu::Light;
use frame::surface::{Surface, face_normal_unpack};
use glam::{DVec2, DVec3, DVec4, IVec3, UVec2, Vec2, Vec3};
use scene::Sky;

const LEAST_COSINE: f64 = 1e-6;
const LARGEST: f64 = 65504.0;
const SUN: u32 = 0;

/// What a ray met.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// Metres.
    pub(crate) distance: f32,
    /// As stored.
    pub(crate) surface: Surface,
    /// Met from the side its normal is on.
    pub(crate) front: bool,
    /// Towards the ray: nothing is reflected below it.
    pub(crate) face: Vec3,
    /// Of the face that the ray entered through, towards the ray.
    pub(crate) entry: Vec3,
    /// The cell whose face was met, and not a plane within.
    pub(crate) face_of: Option<IVec3>,
    /// What a ray leaves that stays on this side, as the structure names it, and one that crosses the surface.
    pub(crate) own: [u32; 2],
    pub(crate) beyond: [u32; 2],
}

impl Hit {
    /// What a ray leaves that goes on from here.
    pub(crate) fn leaves(&self, direction: Vec3) -> [u32; 2] {
        if self.face.dot(direction) > 0.0 { self.own } else { self.beyond }
    }
}

/// A ray that leaves no surface the structure knows.
pub(crate) const NO_OWN: [u32; 2] = [u32::MAX; 2];

/// What a search structure brings: `hit_trace`, `hit_start`, `hit_starts_from`, `hit_leave`, `hit_pass`.
pub(crate) trait Structure {
    fn trace(&self, ray: &Ray, tally: &mut Tally) -> Option<Hit>;
    fn start(&self, point: Vec3, face: Vec3, side: Vec3, wo: Vec3) -> Vec3;
    fn starts_from(&self, point: Vec3, side: Vec3, wo: Vec3) -> [u32; 2];
    fn leave(&self, point: Vec3, hit: &Hit, direction: Vec3) -> Vec3;
    fn pass(&self, point: Vec3, hit: &Hit) -> Vec3;
}

/// What [`Structure::trace`] follows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    pub(crate) distance: f32,
    pub(crate) own: [u32; 2],
}

/// The counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub(crate) rays: u64,
    pub(crate) cut: u64,
    pub(crate) iterations: u64,
    pub(crate) paths: u64,
}

/// One pixel of a G-buffer.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Texel {
    pub(crate) surface: [u32; 4],
    pub(crate) distance: f32,
    pub(crate) face_normal: u32,
    pub(crate) motion_id: [u32; 2],
}

/// One pixel of the image: rgb and mean first length of each lobe, paths that began in each.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pixel {
    pub(crate) lobes: [DVec4; 2],
    pub(crate) samples: [u32; 2],
}

/// All that a path reads.
pub(crate) struct World<'a, S> {
    pub(crate) frame: &'a Frame,
    pub(crate) structure: &'a S,
    pub(crate) sky: &'a Sky,
    pub(crate) lights: &'a [Light],
    pub(crate) table: &'a BrdfTable,
}

#[derive(Clone, Copy, Default)]
struct Path {
    origin: Vec3,
    direction: Vec3,
    first_distance: f32,
    throughput: DVec3,
    own: [u32; 2],
    absorption: DVec3,
    is_alive: bool,
    is_specular: bool,
    is_inside: bool,
    bounce: u32,
}

struct Scatter {
    wi: Vec3,
    weight: DVec3,
    branch: f64,
    transmitted: bool,
    valid: bool,
}

fn luminance(c: DVec3) -> f64 {
    f64::from(frame::cpu::luminance(c.as_vec3().to_array()))
}

fn is_straight(s: &Surface) -> bool {
    s.thin || s.f0 == 0.0
}

fn diffuse_probability(diffuse: DVec3, specular: DVec3, has_specular: bool) -> f64 {
    let d = luminance(diffuse);
    if !has_specular {
        return 1.0;
    }
    if d <= 0.0 {
        return 0.0;
    }
    (d / (d + luminance(specular))).clamp(0.1, 0.9)
}

fn demodulated(surface: &Surface) -> Surface {
    Surface { base: Vec3::ONE, metalness: 0.0, transmission: 0.0, ..*surface }
}

fn scatter(
    brdf: Brdf<'_>,
    surface: &Surface,
    wo: Vec3,
    face: Vec3,
    specular: bool,
    u: [f32; 3],
    inside: bool,
) -> Scatter {
    let (wo, u) = (wo.as_dvec3(), Vec3::from(u).as_dvec3());
    let sample = if specular {
        brdf.sample_specular(surface, wo, u, inside)
    } else {
        brdf.sample_diffuse(&demodulated(surface), wo, DVec2::new(u.x, u.y))
    };
    let wi = sample.wi.as_vec3();
    let below = !sample.transmitted && wi.dot(face) <= 0.0;
    Scatter {
        wi,
        weight: sample.weight,
        branch: sample.branch,
        transmitted: sample.transmitted,
        valid: sample.valid && !below,
    }
}

/// The shader's `brdf_facet` of a sheet: a smooth copy of it transmits by one facet, the sheet itself.
fn sheet_transmits(brdf: Brdf<'_>, s: &Surface, wi: Vec3) -> DVec3 {
    let wi = wi.as_dvec3();
    let wo = if s.normal.as_dvec3().dot(wi) < 0.0 { -wi } else { wi };
    let smooth = Surface { roughness: Vec2::ZERO, ..*s };
    let sample = brdf.sample_specular(&smooth, wo, DVec3::new(0.0, 0.0, 1.0 - f64::EPSILON), false);
    if sample.valid && sample.transmitted { sample.weight * sample.branch } else { DVec3::ZERO }
}

/// Unit direction through a pixel.
pub(crate) fn view_direction(frame: &Frame, pixel: UVec2) -> Vec3 {
    let point = pixel.as_vec2() + 0.5 + Vec2::from(frame.jitter);
    let ndc = Vec2::new(2.0, -2.0) * (point / UVec2::from(frame.trace_size).as_vec2()) + Vec2::new(-1.0, 1.0);
    (Vec3::from(frame.forward) + ndc.x * Vec3::from(frame.right) + ndc.y * Vec3::from(frame.up)).normalize()
}

pub(super) fn roughness_samples(surface: &Surface) -> u32 {
    (1 + (5.0 * surface.roughness.max_element() + 0.5) as u32).clamp(1, 6)
}

/// As `path_resolve`, but for the rounding to half floats.
fn resolve(sums: [DVec4; 2], samples: [u32; 2]) -> Pixel {
    let all = f64::from((samples[0] + samples[1]).max(1));
    let lobes = [0, 1].map(|lobe| {
        let (sum, own) = (sums[lobe], f64::from(samples[lobe].max(1)));
        (sum.truncate() / all).min(DVec3::splat(LARGEST)).extend((sum.w / own).min(LARGEST))
    });
    Pixel { lobes, samples }
}

impl<S: Structure> World<'_, S> {
    fn brdf(&self) -> Brdf<'_> {
        Brdf::new(self.table)
    }

    /// All samples of one pixel; `params.sample` is left alone, `params.branch` says whether glass is followed both ways.
    pub(crate) fn pixel(&self, params: &PathParams, pixel: UVec2, texel: &Texel, tally: &mut Tally) -> Pixel {
        let mut sums = [DVec4::ZERO; 2];
        let mut samples = [0; 2];
        let count = if params.bounces > 0 && texel.distance > 0.0 { params.samples } else { 0 };
        let branches: &[u32] = if params.branch == 0 { &[0] } else { &[1, 2] };
        for (sample, branch) in (0..count).flat_map(|s| branches.iter().map(move |b| (s, *b))) {
            let params = PathParams { sample, branch, ..*params };
            let mut path = self.start(&params, pixel, texel, &mut sums, &mut samples, tally);
            let mut is_first = true;
            while path.is_alive {
                let found = self.advance(&params, &mut path, pixel, tally);
                let length = if is_first { path.first_distance.min(self.frame.diagonal) } else { 0.0 };
                is_first = false;
                sums[usize::from(path.is_specular)] += found.extend(f64::from(length));
            }
        }
        resolve(sums, samples)
    }

    fn start(
        &self,
        params: &PathParams,
        pixel: UVec2,
        texel: &Texel,
        sums: &mut [DVec4; 2],
        samples: &mut [u32; 2],
        tally: &mut Tally,
    ) -> Path {
        let mut path = Path::default();
        let seed = self.frame.seed;
        let surface = Surface::unpack_gbuffer(texel.surface);
        let face = face_normal_unpack(texel.face_normal);
        let is_back = texel.motion_id[1] >> 31 == 1;
        let inside = is_back && surface.transmission > 0.0 && !surface.thin;
        let wo = -view_direction(self.frame, pixel);
        let point = Vec3::from(self.frame.eye) - texel.distance * wo;

        let mut of_pixel = params.samples;
        if params.rule == SampleRule::Roughness as u32 {
            of_pixel = roughness_samples(&surface);
        }
        if params.sample >= of_pixel {
            return path;
        }
        let m = brdf::modulators(&surface, f64::from(surface.normal.dot(wo).max(0.0)), self.table);
        let q = diffuse_probability(m.diffuse, m.specular, brdf::has_specular(&surface));
        let serial = params.first_sample.wrapping_add(params.sample);

        let [_, _, mut z, _] = noise::at(pixel.into(), serial, 0, seed);
        let [turn, ..] = noise::at(pixel.into(), params.first_sample, 2, seed);
        let turned = turn + params.sample as f32 / of_pixel as f32;
        let specular = f64::from(turned - turned.floor()) >= q;
        let smooth = brdf::is_delta(&surface);
        let branches = specular && params.branch != 0 && surface.transmission > 0.0 && smooth;
        let goes_through = params.branch == 2;
        if goes_through && !branches {
            return path;
        }
        if !goes_through {
            tally.paths += 1;
            samples[usize::from(specular)] += 1;
        }

        let is_sun_elsewhere = self.frame.sun_elsewhere != 0;
        let first_light = usize::from(is_sun_elsewhere && self.lights.first().is_some_and(|l| l.kind == SUN));
        if let Some(lights) = self.lights.get(first_light..).filter(|l| !l.is_empty() && !goes_through) {
            let [x, y, ..] = noise::at(pixel.into(), serial, 1, seed);
            let sample = light_sample(lights, self.frame.diagonal, point, [x, y]);
            let origin = self.structure.start(point, face, face, wo);
            let own = self.structure.starts_from(point, face, wo);
            let [diffuse, specular] = self.light(&surface, wo, face, &sample, (origin, own), inside, tally);
            if q > 0.0 {
                sums[0] += diffuse.extend(0.0);
            }
            sums[1] += (specular / m.specular).extend(0.0);
        }

        if branches {
            z = if goes_through { 0.999_999_94 } else { 0.0 };
        }
        let [x, y] = noise::stratified(pixel.into(), serial, seed);
        let mut scatter = scatter(self.brdf(), &surface, wo, face, specular, [x, y, z], inside);
        if !scatter.valid || (branches && scatter.transmitted != goes_through) {
            return path;
        }
        if branches {
            scatter.weight *= scatter.branch;
        }
        let side = if scatter.transmitted { -face } else { face };
        path.origin = self.structure.start(point, face, side, wo);
        path.own = self.structure.starts_from(point, side, wo);
        path.direction = scatter.wi;
        path.throughput = scatter.weight / if specular { (1.0 - q) * m.specular } else { DVec3::splat(q) };
        let passes = scatter.transmitted && is_straight(&surface);
        path.is_inside = inside != (scatter.transmitted && !surface.thin);
        if path.is_inside {
            path.absorption = surface.absorption.as_dvec3();
        }
        path.is_alive = true;
        path.is_specular = specular;
        path.bounce = u32::from(!passes);
        path
    }

    fn advance(&self, params: &PathParams, path: &mut Path, pixel: UVec2, tally: &mut Tally) -> DVec3 {
        let (frame, seed) = (self.frame, self.frame.seed);
        let mut found = DVec3::ZERO;
        tally.rays += 1;
        for passed in 0..PASSES {
            let bounce = path.bounce;
            let serial = params.first_sample.wrapping_add(params.sample);
            let block = 4 * (bounce + 1) + 4096 * passed;
            let ray = Ray {
                origin: path.origin,
                direction: path.direction,
                distance: 4.0 * frame.diagonal,
                own: path.own,
            };
            let Some(hit) = self.structure.trace(&ray, tally) else {
                let sky = self.sky.radiance(path.direction) * frame.radiance_scale;
                path.first_distance += frame.diagonal;
                path.is_alive = false;
                return found + path.throughput * sky.as_dvec3();
            };
            let wo = -path.direction;
            let point = path.origin - hit.distance * wo;
            path.first_distance += hit.distance;
            let mut surface = hit.surface;
            let front = hit.front;
            let solid = surface.transmission > 0.0 && !surface.thin;
            let inside = solid && !front;
            if path.is_inside && (inside || !solid) {
                path.throughput *= (-path.absorption * f64::from(hit.distance)).exp();
            }
            let u = noise::at(pixel.into(), serial, block, seed);
            if u[3] >= surface.coverage {
                path.origin = self.structure.pass(point, &hit);
                path.own = hit.leaves(path.direction);
                continue;
            }
            if front {
                found += path.throughput * surface.emission.as_dvec3();
            } else {
                surface.normal = -surface.normal;
                surface.handedness = -surface.handedness;
            }

            let m = brdf::modulators(&surface, f64::from(surface.normal.dot(wo).max(0.0)), self.table);
            let q = diffuse_probability(m.diffuse, m.specular, brdf::has_specular(&surface));
            let more = bounce < params.bounces;
            if more && !self.lights.is_empty() {
                let [x, y, ..] = noise::at(pixel.into(), serial, block + 1, seed);
                let sample = light_sample(self.lights, frame.diagonal, point, [x, y]);
                let origin = self.structure.leave(point, &hit, sample.wi.as_vec3());
                let [diffuse, specular] =
                    self.light(&surface, wo, hit.face, &sample, (origin, hit.own), inside, tally);
                found += path.throughput * (m.diffuse * diffuse + specular);
            }

            let specular = f64::from(u[2]) >= q;
            let rest = ((f64::from(u[2]) - q) / (1.0 - q).max(1e-6)) as f32;
            let u = [u[0], u[1], rest.min(0.999_999_94)];
            let scatter = scatter(self.brdf(), &surface, wo, hit.face, specular, u, inside);
            let passes = scatter.transmitted && is_straight(&surface);
            if !scatter.valid || (!more && !passes) {
                path.is_alive = false;
                return found;
            }
            let chosen =
                if specular { DVec3::splat(1.0 / (1.0 - q).max(1e-6)) } else { m.diffuse / q.max(1e-6) };
            path.throughput *= scatter.weight * chosen;
            path.direction = scatter.wi;
            path.own = hit.leaves(scatter.wi);
            if solid {
                path.is_inside = inside != scatter.transmitted;
                path.absorption = surface.absorption.as_dvec3();
            }
            if passes {
                path.origin = self.structure.pass(point, &hit);
                continue;
            }
            path.origin = self.structure.leave(point, &hit, scatter.wi);
            path.bounce += 1;
            if bounce + 1 >= params.roulette_from {
                let survival = path.throughput.max_element().clamp(0.05, 0.95);
                if f64::from(noise::at(pixel.into(), serial, block + 2, seed)[0]) >= survival {
                    path.is_alive = false;
                    return found;
                }
                path.throughput /= survival;
            }
            return found;
        }
        path.is_alive = false;
        found
    }

    /// Diffuse over M_d, and specular.
    fn light(
        &self,
        surface: &Surface,
        wo: Vec3,
        face: Vec3,
        sample: &LightSample,
        from: (Vec3, [u32; 2]),
        inside: bool,
        tally: &mut Tally,
    ) -> [DVec3; 2] {
        let normal = surface.normal.as_dvec3();
        let cosine = normal.dot(sample.wi);
        let is_dark = cosine.min(normal.dot(wo.as_dvec3())) < LEAST_COSINE
            || face.as_dvec3().dot(sample.wi) <= 0.0
            || sample.irradiance.max_element() <= 0.0;
        if is_dark {
            return [DVec3::ZERO; 2];
        }
        tally.rays += 1;
        let visibility = self.visibility(from, sample.wi.as_vec3(), sample.distance, tally);
        let arriving = sample.irradiance * cosine * visibility;
        let wo = wo.as_dvec3();
        let specular = self.brdf().eval_side(surface, wo, sample.wi, inside).specular;
        let diffuse = self.brdf().eval(&demodulated(surface), wo, sample.wi).diffuse;
        [arriving * diffuse, arriving * specular]
    }

    fn visibility(&self, from: (Vec3, [u32; 2]), wi: Vec3, distance: f32, tally: &mut Tally) -> DVec3 {
        let mut visibility = DVec3::ONE;
        let (origin, own) = from;
        let mut ray = Ray { origin, direction: wi, distance, own };
        for _ in 0..PASSES {
            let Some(hit) = self.structure.trace(&ray, tally) else {
                return visibility;
            };
            let s = &hit.surface;
            ray.origin = self.structure.pass(ray.origin + hit.distance * wi, &hit);
            ray.distance -= hit.distance;
            ray.own = hit.leaves(wi);
            let coverage = f64::from(s.coverage);
            let mut through = DVec3::splat(1.0 - coverage);
            if s.thin && s.transmission > 0.0 {
                through += coverage * sheet_transmits(self.brdf(), s, wi);
            }
            visibility *= through;
            if visibility.max_element() <= 0.0 {
                return DVec3::ZERO;
            }
        }
        DVec3::ZERO
    }
}
