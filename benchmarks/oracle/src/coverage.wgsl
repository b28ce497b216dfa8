// Which triangle each pixel sees, and how deep it lies. Coverage is the rasterizer's; depth is that of the triangle's plane along the pixel's ray,
// since what rasterizers interpolate between corners loses digits on triangles as long as a street.

struct Lens {
    // Normalized device coordinates of a ray (x, y, 1): scale * ray + shift.
    scale: vec2f,
    shift: vec2f,
    // Nearest and farthest depth that is seen, metres.
    near: f32,
    far: f32,
    // Rays of the middle of the top left pixel, and from pixel to pixel, in the camera's x right, y up, z forward.
    corner: vec2f,
    pitch: vec2f,
}

struct Corner {
    @location(0) position: vec3f,
    // The triangle's plane: 1 / depth along a ray is its product with the ray.
    @location(1) plane: vec3f,
    @location(2) uv: vec2f,
    // Number of the triangle from 1, and of its material.
    @location(3) name: vec2u,
}

struct Fragment {
    @builtin(position) place: vec4f,
    @location(0) @interpolate(flat) plane: vec3f,
    @location(1) uv: vec2f,
    @location(2) @interpolate(flat) name: vec2u,
}

struct Seen {
    @location(0) triangle: u32,
    @location(1) depth: f32,
    @builtin(frag_depth) order: f32,
}

@group(0) @binding(0) var<uniform> lens: Lens;
// For each material: where its holes begin in `holes`, and columns and rows of its texture; no columns without holes.
@group(0) @binding(1) var<storage, read> masks: array<vec4u>;
// A bit for each texel that is a hole.
@group(0) @binding(2) var<storage, read> holes: array<u32>;

@vertex
fn project(corner: Corner) -> Fragment {
    let p = corner.position;
    var to: Fragment;
    // The third component only clips what is too near.
    to.place = vec4f(lens.scale * p.xy + lens.shift * p.z, p.z - lens.near, p.z);
    to.plane = corner.plane;
    to.uv = corner.uv;
    to.name = corner.name;
    return to;
}

fn is_hole(material: u32, uv: vec2f) -> bool {
    let mask = masks[material];
    if mask.y == 0u {
        return false;
    }
    let place = vec2f(uv.x - floor(uv.x), 1.0 - (uv.y - floor(uv.y)));
    let texel = min(vec2u(place * vec2f(mask.yz)), mask.yz - 1u);
    let bit = texel.y * mask.y + texel.x;
    return (holes[mask.x + bit / 32u] >> (bit % 32u) & 1u) != 0u;
}

@fragment
fn see(at: Fragment) -> Seen {
    let ray = vec3f(lens.corner + floor(at.place.xy) * lens.pitch, 1.0);
    let inverse = dot(at.plane, ray);
    if inverse < 1.0 / lens.far || is_hole(at.name.y, at.uv) {
        discard;
    }
    return Seen(at.name.x, 1.0 / inverse, min(lens.near * inverse, 1.0));
}
