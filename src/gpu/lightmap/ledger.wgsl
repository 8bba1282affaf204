// Where the power went. Group 0: settings, shooters, sums of power by workgroup of `receive`, weights of a hemicube's
// pixels (eq. 8), power that was lost by shooter, the ledger, depth and sides of the hemicubes.

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var<storage, read> shooters: array<Shooter>;
@group(0) @binding(2) var<storage, read> sums: array<PowerSums>;
@group(0) @binding(3) var<storage, read> delta_form_factors: array<f32>;
@group(0) @binding(4) var<storage, read_write> lost: array<Lost>;
@group(0) @binding(5) var<storage, read_write> ledger: Ledger;
// Depth, as a texture of numbers: OpenGL loads no single texels of depth textures.
@group(0) @binding(6) var depth: texture_2d<f32>;
// 0 where nothing is seen, or a back face.
@group(0) @binding(7) var sides: texture_2d<u32>;

// Power of one shooter that left the scene, and that met back faces.
struct Lost {
    escaped: vec3f,
    spare: f32,
    on_backs: vec3f,
    spare_too: f32,
}

struct Ledger {
    // Since the start.
    arrived: vec3f,
    shooters: u32,
    reflected: vec3f,
    spare: f32,
    escaped: vec3f,
    spare_too: f32,
    on_backs: vec3f,
    spare_three: f32,
    // Now.
    unshot: vec3f,
    spare_four: f32,
}

var<workgroup> parts: array<vec2f, 256>;
var<workgroup> totals: array<Ledger, 256>;

// One workgroup a shooter: the power through pixels that show nothing, and through those that show back faces.
@compute @workgroup_size(256)
fn find_lost(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) local: u32) {
    let slot = settings.first_slot + group.x;
    let corner = tile_corner(slot, settings);
    let pixels = 3u * settings.resolution * settings.resolution;
    var part = vec2f(0.0);
    for (var pixel = local; pixel < pixels; pixel += 256u) {
        let place = corner + vec2u(pixel % settings.resolution, pixel / settings.resolution);
        if textureLoad(sides, place, 0).x == 0u {
            let is_back = textureLoad(depth, place, 0).x > 0.0;
            part += delta_form_factors[pixel] * select(vec2f(1.0, 0.0), vec2f(0.0, 1.0), is_back);
        }
    }
    parts[local] = part;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if local < half {
            parts[local] += parts[local + half];
        }
    }
    if local == 0u {
        let shooter = shooters[slot];
        let power = shooter.area * shooter.radiosity;
        lost[slot] = Lost(parts[0].x * power, 0.0, parts[0].y * power, 0.0);
    }
}

@compute @workgroup_size(256)
fn add_up(@builtin(local_invocation_index) local: u32) {
    var mine: Ledger;
    let group_count = (settings.receiver_count + 63u) / 64u;
    for (var group = local; group < group_count; group += 256u) {
        let part = sums[group];
        mine.arrived += part.arrived;
        mine.reflected += part.reflected;
        mine.unshot += part.unshot;
    }
    for (var slot = settings.first_slot + local; slot < settings.end_slot; slot += 256u) {
        mine.escaped += lost[slot].escaped;
        mine.on_backs += lost[slot].on_backs;
        mine.shooters += select(0u, 1u, shooters[slot].area > 0.0);
    }
    // Chosen, but left to the next submissions.
    for (var slot = settings.end_slot + local; slot < settings.slot_count; slot += 256u) {
        mine.unshot += shooters[slot].area * shooters[slot].radiosity;
    }
    totals[local] = mine;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if local < half {
            totals[local].arrived += totals[local + half].arrived;
            totals[local].reflected += totals[local + half].reflected;
            totals[local].escaped += totals[local + half].escaped;
            totals[local].on_backs += totals[local + half].on_backs;
            totals[local].unshot += totals[local + half].unshot;
            totals[local].shooters += totals[local + half].shooters;
        }
    }
    if local == 0u {
        ledger.arrived += totals[0].arrived;
        ledger.reflected += totals[0].reflected;
        ledger.escaped += totals[0].escaped;
        ledger.on_backs += totals[0].on_backs;
        ledger.shooters += totals[0].shooters;
        ledger.unshot = totals[0].unshot;
    }
}
