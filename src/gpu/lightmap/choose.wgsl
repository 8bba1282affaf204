// Which groups shoot next: those of the most unshot power, found by reduction over tiles of 256 groups.
// Group 0: settings, receivers, groups, unshot radiosity, power by group, best of each tile, chosen, shooters, charts,
// the chart that shoots, shots of each texel, power of the groups that may shoot.

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(2) var<storage, read> groups: array<Group>;
@group(0) @binding(3) var<storage, read_write> unshot: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> power: array<f32>;
@group(0) @binding(5) var<storage, read_write> best_of_tile: array<Best>;
@group(0) @binding(6) var<storage, read_write> chosen: array<u32>;
@group(0) @binding(7) var<storage, read_write> shooters: array<Shooter>;

@group(0) @binding(8) var<storage, read> charts: array<ChartGroups>;
@group(0) @binding(9) var<storage, read_write> order: Order;
// The shooter, counted from 1, that a texel first shot with (0: none yet), and how often it has shot.
@group(0) @binding(10) var<storage, read_write> shots: array<vec2u>;
// Power of the groups that may shoot now.
@group(0) @binding(11) var<storage, read_write> offered: array<f32>;

struct ChartGroups {
    first: u32,
    count: u32,
    area: f32,
    spare: f32,
}

// The groups of the present chart that have still to shoot.
struct Order {
    next: u32,
    end: u32,
}

struct Best {
    power: f32,
    group: u32,
}

const NO_GROUP: u32 = 0xffffffffu;

var<workgroup> candidates: array<Best, 256>;
var<workgroup> sums: array<vec3f, 256>;

// The better of two: equal powers go to the lower number, so that every device chooses alike.
fn better(a: Best, b: Best) -> Best {
    if b.power > a.power || (b.power == a.power && b.group < a.group) {
        return b;
    }
    return a;
}

fn reduce_candidates(local: u32) {
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if local < half {
            candidates[local] = better(candidates[local], candidates[local + half]);
        }
    }
    workgroupBarrier();
}

@compute @workgroup_size(256)
fn find_power(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= settings.group_count {
        return;
    }
    let group = groups[id.x];
    var sum = 0.0;
    for (var index = group.first; index < group.first + group.count; index++) {
        let radiosity = unshot[index];
        sum += (radiosity.x + radiosity.y + radiosity.z) * receivers[index].area;
    }
    power[id.x] = sum;
}

// True if a group has little enough power to shoot as one.
fn is_small(group: u32) -> bool {
    return power[group] <= groups[group].most_power;
}

// Offered is, of each group and its parts, the largest that may shoot as one: so no two of them have a texel in common.
@compute @workgroup_size(256)
fn find_best(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) tile: vec3u,
) {
    candidates[local] = Best(0.0, NO_GROUP);
    if id.x < settings.group_count {
        var is_offered = is_small(id.x);
        for (var above = groups[id.x].parent; above != NO_GROUP; above = groups[above].parent) {
            is_offered = is_offered && !is_small(above);
        }
        offered[id.x] = select(0.0, power[id.x], is_offered);
        candidates[local] = Best(offered[id.x], id.x);
    }
    reduce_candidates(local);
    if local == 0u {
        best_of_tile[tile.x] = candidates[0];
    }
}

@compute @workgroup_size(256)
fn choose(@builtin(local_invocation_index) local: u32) {
    let tile_count = (settings.group_count + 255u) / 256u;
    for (var slot = 0u; slot < settings.slot_count; slot++) {
        var best = Best(0.0, NO_GROUP);
        for (var tile = local; tile < tile_count; tile += 256u) {
            best = better(best, best_of_tile[tile]);
        }
        candidates[local] = best;
        reduce_candidates(local);
        let found = candidates[0];
        workgroupBarrier();
        // Its tile looks again, without it.
        let tile = select(0u, found.group / 256u, found.power > 0.0);
        let mine = tile * 256u + local;
        candidates[local] = Best(0.0, NO_GROUP);
        if mine < settings.group_count && mine != found.group {
            candidates[local] = Best(offered[mine], mine);
        }
        if mine == found.group {
            offered[mine] = 0.0;
        }
        reduce_candidates(local);
        if local == 0u {
            best_of_tile[tile] = candidates[0];
            chosen[slot] = select(NO_GROUP, found.group, found.power > 0.0);
        }
        storageBarrier();
        workgroupBarrier();
    }
}

// The other order: the chart of the highest mean unshot radiosity shoots with all its groups, then the next.
@compute @workgroup_size(256)
fn choose_mesh(@builtin(local_invocation_index) local: u32) {
    for (var slot = 0u; slot < settings.slot_count; slot++) {
        var best = Best(0.0, NO_GROUP);
        for (var chart = local; chart < arrayLength(&charts); chart += 256u) {
            var sum = 0.0;
            for (var group = charts[chart].first; group < charts[chart].first + charts[chart].count; group++) {
                sum += offered[group];
            }
            best = better(best, Best(sum / charts[chart].area, chart));
        }
        candidates[local] = best;
        reduce_candidates(local);
        if local == 0u {
            let found = candidates[0];
            if order.next >= order.end && found.power > 0.0 {
                order.next = charts[found.group].first;
                order.end = order.next + charts[found.group].count;
            }
            let is_left = order.next < order.end;
            chosen[slot] = select(NO_GROUP, order.next, is_left);
            if is_left {
                offered[order.next] = 0.0;
                order.next += 1u;
            }
        }
        storageBarrier();
        workgroupBarrier();
    }
}

// One workgroup a slot: the chosen group's unshot power becomes the shooter's, and the group's is spent.
@compute @workgroup_size(256)
fn take(@builtin(workgroup_id) slot: vec3u, @builtin(local_invocation_index) local: u32) {
    let index = chosen[slot.x];
    let is_used = index != NO_GROUP;
    let group = groups[select(index, 0u, !is_used)];
    var sum = vec3f(0.0);
    if is_used {
        for (var texel = group.first + local; texel < group.first + group.count; texel += 256u) {
            sum += unshot[texel].xyz * receivers[texel].area;
            unshot[texel] = vec4f(0.0);
            let shooter = settings.shooter_count + slot.x + 1u;
            shots[texel] = vec2u(select(shots[texel].x, shooter, shots[texel].x == 0u), shots[texel].y + 1u);
        }
    }
    sums[local] = sum;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if local < half {
            sums[local] += sums[local + half];
        }
    }
    if local == 0u {
        var shooter: Shooter;
        shooter.centre = group.centre;
        shooter.area = select(0.0, group.area, is_used);
        shooter.origin = group.origin;
        shooter.first = group.first;
        shooter.normal = group.normal;
        shooter.count = group.count;
        shooter.half_u = group.half_u;
        shooter.half_v = group.half_v;
        shooter.tangent = group.tangent;
        shooter.radiosity = sums[0] / group.area;
        shooters[slot.x] = shooter;
    }
}
