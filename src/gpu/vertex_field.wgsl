// The field of a view that lies at the vertices. Comes after mesh_view.wgsl.

const HAS_MAP = false;

fn field(in: Fragment) -> vec3f {
    return in.irradiance;
}
