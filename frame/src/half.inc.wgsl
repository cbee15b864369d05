// What an `rgba16float` texture should hold. Stores may cut the rest off instead of rounding (Mesa's software driver
// does): ten passes would then lose 0.3 % of the light.

const HALF_LARGEST = 65504.0;

// By the exponent's bits: a comparison with itself may be folded away.
fn half_is_finite(x: vec4f) -> vec4<bool> {
    return (bitcast<vec4u>(x) & vec4u(0x7f800000u)) != vec4u(0x7f800000u);
}

// The nearest half float (ties to even) of numbers that are not negative, at most the largest; 0 for what is not finite.
fn half_rounded(x: vec4f) -> vec4f {
    let bits = bitcast<vec4u>(x);
    let nearest = (bits + vec4u(0xfffu) + ((bits >> vec4u(13u)) & vec4u(1u))) & vec4u(0xffffe000u);
    return min(bitcast<vec4f>(select(vec4u(0u), nearest, half_is_finite(x))), vec4f(HALF_LARGEST));
}
