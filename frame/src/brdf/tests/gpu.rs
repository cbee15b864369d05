//! The shader against its twin: parsed, validated, and run on the adapter there is.

use super::*;
use crate::{Bind, Gpu, Kernel, KernelDesc, Recorder, Room};

const COUNT: usize = 1 << 14;

const SHADER: &str = "
struct Case { surface: vec4u, wo: vec3f, inside: u32, u: vec3f, mu: f32, wi: vec3f, pad: u32 }
struct Drawn { wi: vec3f, pdf: f32, weight: vec3f, flags: u32 }
struct Result {
  diffuse: Drawn, specular: Drawn,
  value_diffuse: vec3f, pdf_diffuse: f32, value_specular: vec3f, pdf_specular: f32,
  modulator_diffuse: vec3f, branch: f32, modulator_specular: vec3f, pad: u32,
}
@group(2) @binding(0) var<storage, read> in_cases: array<Case>;
@group(3) @binding(0) var<storage, read_write> out_results: array<Result>;

fn drawn(s: BrdfSample) -> Drawn {
  return Drawn(s.wi, s.pdf, s.weight, u32(s.valid) | (u32(s.delta) << 1u) | (u32(s.transmitted) << 2u));
}

@compute @workgroup_size(64)
fn sample_and_evaluate(@builtin(global_invocation_id) id: vec3u) {
  let given = in_cases[id.x];
  let s = surface_unpack_gbuffer(given.surface);
  let inside = given.inside == 1u;
  brdf_look(s, given.wo);
  let diffuse = brdf_sample_diffuse(s, given.wo, given.u.xy);
  let specular = brdf_sample_specular(s, given.wo, given.u, inside);
  let value = brdf_eval_side(s, given.wo, given.wi, inside);
  let modulators = brdf_modulators(s, given.mu);
  out_results[id.x] = Result(
    drawn(diffuse), drawn(specular),
    value.diffuse, value.pdf_diffuse, value.specular, value.pdf_specular,
    modulators.diffuse, specular.branch, modulators.specular, 0u,
  );
}";

/// `Case` above.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Case {
    surface: [u32; 4],
    wo: [f32; 3],
    inside: u32,
    u: [f32; 3],
    mu: f32,
    wi: [f32; 3],
    pad: u32,
}

/// `Drawn` above.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Drawn {
    wi: [f32; 3],
    pdf: f32,
    weight: [f32; 3],
    flags: u32,
}

/// `Result` above.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Found {
    diffuse: Drawn,
    specular: Drawn,
    value_diffuse: [f32; 3],
    pdf_diffuse: f32,
    value_specular: [f32; 3],
    pdf_specular: f32,
    modulator_diffuse: [f32; 3],
    branch: f32,
    modulator_specular: [f32; 3],
    pad: u32,
}

fn flags(s: &Sample) -> u32 {
    u32::from(s.valid) | (u32::from(s.delta) << 1) | (u32::from(s.transmitted) << 2)
}

/// Distance relative to the larger of `wanted` and 1.
fn distance(found: [f32; 3], wanted: DVec3) -> f64 {
    (Vec3::from_array(found).as_dvec3() - wanted).abs().max_element() / wanted.abs().max_element().max(1.0)
}

fn cases() -> Vec<Case> {
    let mut random = Random(30);
    let case = |i: usize| {
        let s = random.surface();
        let n = s.normal.as_dvec3();
        let mut wo = direction(2.0 * random.next() - 1.0, TAU * random.next());
        if wo.dot(n) < 0.0 && !i.is_multiple_of(16) {
            wo -= n * (2.0 * wo.dot(n));
        }
        let wi = direction(2.0 * random.next() - 1.0, TAU * random.next());
        Case {
            surface: s.pack_gbuffer(hash(i as u32)),
            wo: wo.normalize().as_vec3().to_array(),
            inside: u32::from(random.next() < 0.5),
            u: random.three().as_vec3().to_array(),
            mu: random.next() as f32,
            wi: wi.as_vec3().to_array(),
            pad: 0,
        }
    };
    (0..COUNT).map(case).collect()
}

fn run(gpu: &Gpu, brdf: &Brdf<'_>, cases: &[Case]) -> Vec<Found> {
    let kernel = Kernel::new(
        gpu,
        &KernelDesc {
            name: "brdf/tests",
            sources: &[surface::WGSL, WGSL, SHADER],
            entry: "sample_and_evaluate",
            workgroup: [64, 1, 1],
            bindings: &[
                Bind::uniform_array(1, 14, "brdf_table"),
                Bind::storage_read(2, 0, "in_cases"),
                Bind::storage(3, 0, "out_results"),
            ],
            constants: &brdf.rules.constants(),
        },
    )
    .unwrap();
    let table = brdf.table.upload(gpu).unwrap();
    let in_cases = gpu.storage(Room::Frame, "in_cases", cases).unwrap();
    let out_results =
        gpu.storage(Room::Frame, "out_results", &vec![[0u8; size_of::<Found>()]; COUNT]).unwrap();
    let mut recorder = Recorder::new(gpu);
    let resources =
        [table.as_entire_binding(), in_cases.as_entire_binding(), out_results.as_entire_binding()];
    recorder.compute("brdf/tests", &kernel, &resources, [COUNT as u32 / 64, 1, 1]);
    recorder.finish().unwrap();
    gpu.read_buffer(&out_results).unwrap()
}

/// Errors of one quantity, for its quantiles.
#[derive(Default)]
struct Errors(Vec<f64>);

impl Errors {
    fn assert(mut self, name: &str, most: f64, nearly_all: f64) {
        self.0.sort_by(f64::total_cmp);
        let at = |share: f64| self.0[(share * (self.0.len() - 1) as f64) as usize];
        println!(
            "{name}: {} compared, median {:.1e}, 99 % {:.1e}, 99.9 % {:.1e}",
            self.0.len(),
            at(0.5),
            at(0.99),
            at(0.999)
        );
        assert!(self.0.len() > COUNT / 10, "{name}: too few compared");
        assert!(at(0.99) < most, "{name}: {} at 99 %", at(0.99));
        assert!(at(0.999) < nearly_all, "{name}: {} at 99.9 %", at(0.999));
    }
}

#[test]
fn the_shader_validates_without_an_adapter() {
    let source = [surface::WGSL, WGSL, SHADER].join("\n");
    let module =
        naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    // Half floats packed in words are core WGSL; naga asks for them by name.
    let capabilities = naga::valid::Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
}

#[test]
fn the_shader_agrees_with_its_twin() {
    let gpu = Gpu::new(None).expect("this test needs an adapter");
    let cases = cases();
    for brdf in all_rules() {
        compare(&gpu, &brdf, &cases);
    }
}

fn compare(gpu: &Gpu, brdf: &Brdf<'_>, cases: &[Case]) {
    let found = run(gpu, brdf, cases);
    let [mut drawn, mut weights, mut densities, mut values, mut modulated] =
        [(); 5].map(|()| Errors::default());
    let mut otherwise = 0;
    for (case, found) in cases.iter().zip(&found) {
        let s = Surface::unpack_gbuffer(case.surface);
        let [wo, u, wi] = [case.wo, case.u, case.wi].map(|v| Vec3::from_array(v).as_dvec3());
        let inside = case.inside == 1;
        let diffuse = brdf.sample_diffuse(&s, wo, u.truncate());
        let specular = brdf.sample_specular(&s, wo, u, inside);
        for (found, wanted) in [(found.diffuse, diffuse), (found.specular, specular)] {
            let all = found.weight.iter().chain(&found.wi).chain([&found.pdf]).all(|x| x.is_finite());
            assert!(all && found.weight.iter().all(|w| *w >= 0.0), "{found:?}");
            if found.flags != flags(&wanted) {
                otherwise += 1;
            } else if wanted.valid {
                drawn.0.push(distance(found.wi, wanted.wi));
                weights.0.push(distance(found.weight, wanted.weight));
                densities.0.push((f64::from(found.pdf) - wanted.pdf).abs() / wanted.pdf.max(1.0));
            }
        }
        let value = brdf.eval_side(&s, wo, wi, inside);
        values.0.push(distance(found.value_diffuse, value.diffuse));
        values.0.push(distance(found.value_specular, value.specular));
        values.0.push((f64::from(found.pdf_diffuse) - value.pdf_diffuse).abs());
        values
            .0
            .push((f64::from(found.pdf_specular) - value.pdf_specular).abs() / value.pdf_specular.max(1.0));
        let wanted = modulators(&s, case.mu.into(), brdf.table);
        modulated.0.push(distance(found.modulator_diffuse, wanted.diffuse));
        modulated.0.push(distance(found.modulator_specular, wanted.specular));
    }
    println!("{}: {otherwise} of {} drawn otherwise", gpu.info.name, 2 * COUNT);
    // A branch or a horizon within rounding of its threshold.
    assert!(otherwise < COUNT / 500, "{otherwise}");
    // f32 against f64. The software adapter stays below 1e-6 at 99 %; others may round a division by 2.5 ulp and a sine
    // by 2^-11, which a lobe of alpha 1e-3 magnifies.
    drawn.assert("directions", 1e-4, 1e-3);
    // Narrow lobes find their facet again from the two directions.
    weights.assert("weights", 5e-4, 2e-3);
    densities.assert("densities", 1e-3, 1e-2);
    values.assert("values", 1e-4, 1e-3);
    // An arc sine and two powers lie between them.
    modulated.assert("modulators", 2e-4, 1e-3);
}
