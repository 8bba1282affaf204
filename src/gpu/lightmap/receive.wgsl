// What shooters give to texels (eq. 2 over pairs of patches). It comes after visibility.wgsl and after what declares settings,
// shooters and what a shooter sees (`seen`): see_by_depth.wgsl or see_by_item.wgsl. Group 0: those, receivers, irradiance,
// unshot radiosity, sums of power by workgroup.

@group(0) @binding(2) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(3) var<storage, read_write> irradiance: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> unshot: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> sums: array<PowerSums>;

// A shooter nearer than this many times the root of its area is integrated as a polygon.
override near_ratio: f32 = 5.0;

// Heights over a shooter's plane below this part of its side are rounding.
const LEAST_HEIGHT: f32 = 1e-3;

var<workgroup> shared_sums: array<PowerSums, 64>;

// The form factor from a receiver to a shooter in full view of it. Of the shooter, only what is needed is read: that is
// what a software driver spends its time on.
fn form_factor(receiver: Receiver, slot: u32) -> f32 {
    let area = shooters[slot].area;
    let offset = shooters[slot].centre - receiver.position;
    let shooter_cosine = -dot(offset, shooters[slot].normal);
    // What lies in the shooter's plane, but for rounding, gets nothing.
    if area <= 0.0 || shooter_cosine <= LEAST_HEIGHT * sqrt(area) {
        return 0.0;
    }
    let distance_squared = dot(offset, offset);
    if settings.attenuation == 0u && distance_squared < near_ratio * near_ratio * area {
        let half_u = shooters[slot].half_u;
        let half_v = shooters[slot].half_v;
        let corners = array<vec3f, 4>(
            offset - half_u - half_v,
            offset + half_u - half_v,
            offset + half_u + half_v,
            offset - half_u + half_v,
        );
        return polygon_form_factor(corners, receiver.shading_normal);
    }
    let cosine = dot(offset, receiver.shading_normal);
    if cosine <= 0.0 || dot(offset, receiver.geometric_normal) <= 0.0 {
        return 0.0;
    }
    let physical = area * cosine * shooter_cosine / (PI * distance_squared * distance_squared);
    switch settings.attenuation {
        case 1u: { return physical * settings.patch_area / area * sqrt(distance_squared); }
        case 2u: { return physical * settings.patch_area / area; }
        default: { return physical; }
    }
}

@compute @workgroup_size(64)
fn receive(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) group: vec3u,
) {
    var mine: PowerSums;
    let index = settings.first_receiver + id.x;
    if index < settings.end_receiver {
        let receiver = receivers[index];
        // One shooter after the other, so that it does not matter which of them come in one submission.
        var total = irradiance[index].xyz;
        var still_unshot = unshot[index].xyz;
        for (var slot = settings.first_slot; slot < settings.end_slot; slot++) {
            // On a bent surface a group's own texels may lie before its plane.
            let is_own = index - shooters[slot].first < shooters[slot].count;
            // What a hemicube's pixels let through at the foot of a wall goes to no other room.
            let is_apart = shooters[slot].count > 0u && receivers[shooters[slot].first].room != receiver.room;
            let factor = select(form_factor(receiver, slot), 0.0, is_own || is_apart);
            if factor > 0.0 {
                let added = factor * seen(receiver, slot) * shooters[slot].radiosity;
                total += added;
                still_unshot += receiver.reflectance * added;
                mine.arrived += receiver.area * added;
            }
        }
        irradiance[index] = vec4f(total, 0.0);
        unshot[index] = vec4f(still_unshot, 0.0);
        mine.reflected = receiver.reflectance * mine.arrived;
        mine.unshot = receiver.area * still_unshot;
    }
    shared_sums[local] = mine;
    for (var half = 32u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if local < half {
            shared_sums[local].arrived += shared_sums[local + half].arrived;
            shared_sums[local].reflected += shared_sums[local + half].reflected;
            shared_sums[local].unshot += shared_sums[local + half].unshot;
        }
    }
    if local == 0u {
        sums[settings.first_receiver / 64u + group.x] = shared_sums[0];
    }
}
