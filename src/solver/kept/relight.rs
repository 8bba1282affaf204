//! Another light, other reflectances or emissions, on the elements and rows of a solve: no gather ray is traced.
//!
//! Direct light is computed anew where it may have changed, the bounces are sums over the rows. The elements stay those
//! that followed the light of the solve.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use glam::Vec3;
use rayon::prelude::*;

use super::{Context, Kept, mean};
use crate::{
    scene::{AreaLight, Scene, Tessellation, area_light::AreaLightState},
    solver::{
        energy::VertexWeights,
        monitor::Monitor,
        settings::{Iteration, SolveSettings},
        solution::SolutionInfo,
        solve::{Computed, Problem, SolveReport, Solved},
    },
    transport::{
        Lights,
        direct::{DirectLight, ShadowRays},
        lights::{DirectMethod, FinderCounts},
        visible_light::Scratch,
    },
};

/// Vertices that one task handles.
const PER_TASK: usize = 64;

/// With more vertices than this a quick answer is shown first.
const QUICK_FROM: usize = 50_000;

/// Shadow rays a vertex for a quick answer, if a quarter of them disagree, and what fraction of the gathered light it may
/// leave out: its rays in penumbras leave more.
const QUICK_LIGHT_RAYS: u32 = 16;
const QUICK_UNABSORBED: f32 = 0.03;

/// What takes longer is shown on its way.
const SHOWN_AFTER: Duration = Duration::from_millis(50);

/// What has changed since the solve.
#[derive(Clone, Copy)]
struct Changes {
    area_light: bool,
    emission: bool,
    materials: bool,
}

impl Kept {
    /// The settings that it was solved with.
    pub fn settings(&self) -> &SolveSettings {
        &self.problem.settings
    }

    /// The elements.
    pub fn tessellation(&self) -> &Arc<Tessellation> {
        &self.tessellation
    }

    /// Why this scene cannot be lit on these rows, if it cannot; one line. A scene that differs in its materials'
    /// reflectance and emission alone can, but for materials that were black: rays kept nothing of what they met there.
    pub fn refuses(&self, scene: &Scene) -> Option<String> {
        let known = &self.problem.scene;
        if known.mesh.triangles.len() != scene.mesh.triangles.len() || known.materials.len() != scene.materials.len() {
            return Some(String::from("it is another scene: solve it anew"));
        }
        let mut pairs = known.materials.iter().zip(&scene.materials);
        let is_refused = pairs.find(|(before, now)| {
            let textures = |material: &crate::scene::Material| {
                (material.reflectance_texture, material.opacity_texture, material.opacity.to_bits())
            };
            let was_black = before.reflectance.max_element() <= 0.0 && now.reflectance.max_element() > 0.0;
            was_black || textures(before) != textures(now)
        });
        is_refused.map(|(_, material)| format!("{} was black or is cut otherwise: solve it anew", material.name))
    }

    /// The converged field with another light and in `scene`, which is that of the solve but for its materials (see
    /// [`Kept::refuses`]). It depends on the solve, the scene and the light alone, not on what was lit in between. A
    /// bounce limit in the settings is kept to; else the best combination of few gathers is taken, to the settings'
    /// tolerance. Light of emissive triangles that is sampled is found by samples alone once an emission has changed.
    ///
    /// The elements stay as they were cut for the light of the solve. A cancelled one has direct light alone. To whoever
    /// listens a large field is first shown by [`Kept::preview`] where direct light must be looked for.
    pub fn relight(&self, scene: &Arc<Scene>, light: Option<AreaLightState>, monitor: &Monitor) -> Solved {
        let started = Instant::now();
        let problem = self.problem_with(scene, light);
        if monitor.is_watched()
            && self.buried.len() > QUICK_FROM
            && self.looks_for_light(&problem)
            && let Some(total) = self.preview(scene, light, monitor)
        {
            monitor.set_live(&total);
        }
        let (bounces, report, info) = self.with_direct(&problem, monitor, |context, direct, changes, mut report| {
            report.seconds_following_direct = started.elapsed().as_secs_f64();
            let changed_weights = changes.materials.then(|| VertexWeights::new(scene, &self.tessellation));
            let weights = changed_weights.as_ref().unwrap_or(&self.weights);
            let bounces_started = Instant::now();
            let bounces = if problem.settings.iteration == Iteration::Neumann {
                self.bounces(context, direct, weights, &mut report).0
            } else {
                self.converged(context, direct, weights, changes, &mut report)
            };
            report.bounce_seconds = bounces_started.elapsed().as_secs_f64();
            (bounces, report, self.info_of(&problem, changes, monitor))
        });
        let (buried, tessellation) = (self.buried_in_part(), Arc::clone(&self.tessellation));
        Computed { bounces, buried, tessellation, kept: None }.into_solved(info, report, (monitor, started))
    }

    /// All light [W/m²] at the vertices as [`Kept::relight`] finds it, in a fraction of the time: where the light must be
    /// looked for again it is with few rays, so that penumbras have some noise, and the bounces end sooner. `None` if it
    /// was cancelled.
    pub fn preview(&self, scene: &Arc<Scene>, light: Option<AreaLightState>, monitor: &Monitor) -> Option<Vec<Vec3>> {
        let mut problem = self.problem_with(scene, light);
        if self.looks_for_light(&problem) {
            let settings = &mut problem.settings;
            settings.unabsorbed = settings.unabsorbed.max(QUICK_UNABSORBED);
            if settings.direct == DirectMethod::Analytic {
                settings.direct = DirectMethod::Ratio;
                settings.light_rays = settings.light_rays.min(QUICK_LIGHT_RAYS);
            }
        }
        let total = self.with_direct(&problem, monitor, |context, mut total, changes, mut report| {
            let mut gathered = Vec::new();
            if !context.lights.is_empty() {
                let known = Some(&self.known).filter(|_| !changes.materials);
                self.converge(context, &total, known, &mut |last, _| gathered = last, &mut report)?;
                let indirect = self.spread_light(gathered);
                total.iter_mut().zip(indirect).for_each(|(total, indirect)| *total += indirect);
            }
            Some(total)
        });
        total.filter(|_| !monitor.is_cancelled())
    }

    /// Finds direct light [W/m²] at the vertices, and goes on with it.
    fn with_direct<T>(
        &self,
        problem: &Problem,
        monitor: &Monitor,
        go_on: impl FnOnce(&Context, Vec<Vec3>, Changes, SolveReport) -> T,
    ) -> T {
        let Problem { scene, light, settings, .. } = problem;
        let lights = Lights::new(scene, light.map(|light| light.to_local(&scene.frame)));
        let is_cancelled = || monitor.is_cancelled();
        let finders = FinderCounts { gather: 0, light: settings.light_rays };
        let context = Context { problem, monitor, lights: &lights, finders, is_cancelled: &is_cancelled };
        let changes = self.changes(problem);
        let mut report = SolveReport::new(&lights, scene, settings.iteration);
        let direct = self.direct_values(self.direct_light(&context, changes, &mut report));
        go_on(&context, direct, changes, report)
    }

    fn problem_with(&self, scene: &Arc<Scene>, light: Option<AreaLightState>) -> Problem {
        let settings = self.problem.settings.clone();
        let iteration = if settings.bounces.is_some() { Iteration::Neumann } else { Iteration::Krylov };
        let settings = SolveSettings { iteration, ..settings };
        Problem { scene: Arc::clone(scene), light, settings, ..self.problem.clone() }
    }

    fn changes(&self, problem: &Problem) -> Changes {
        let (before, now) = (&self.problem.scene, &problem.scene);
        let emission =
            |scene: &Scene| scene.materials.iter().map(|material| material.emitted_radiance).collect::<Vec<_>>();
        let materials = !Arc::ptr_eq(before, now) && before.materials != now.materials;
        Changes {
            area_light: self.problem.light != problem.light,
            emission: materials && emission(before) != emission(now),
            materials,
        }
    }

    /// True if direct light does not follow from that of the solve.
    fn looks_for_light(&self, problem: &Problem) -> bool {
        let changes = self.changes(problem);
        let light = problem.light.map(|light| light.to_local(&problem.scene.frame));
        changes.emission || (changes.area_light && self.brightness(light.as_ref()).is_none())
    }

    /// Direct irradiance [W/m²] at the vertices, but for the buried ones.
    fn direct_light(&self, context: &Context, changes: Changes, report: &mut SolveReport) -> Vec<Vec3> {
        if !changes.area_light && !changes.emission {
            return self.direct.light.iter().map(DirectLight::irradiance).collect();
        }
        if let (Some(factor), false) = (self.brightness(context.lights.area_light.as_ref()), changes.emission) {
            return self.direct.light.iter().map(|light| factor * light.area_light + light.emitters).collect();
        }
        let lights = if changes.emission { context.lights.clone() } else { context.lights.without_emitters() };
        let context = Context { lights: &lights, ..*context };
        let vertices: Vec<u32> = (0..self.buried.len() as u32).collect();
        let found = vertices.par_chunks(PER_TASK).map(|vertices| self.direct_light_at(&context, vertices));
        let found: Vec<(Vec<DirectLight>, ShadowRays)> = found.collect();
        for (_, rays) in &found {
            report.enter_shadow_rays(rays);
        }
        let light = found.into_iter().flat_map(|(light, _)| light).zip(&self.direct.light);
        light.map(|(new, old)| new.area_light + if changes.emission { new.emitters } else { old.emitters }).collect()
    }

    fn direct_light_at(&self, context: &Context, vertices: &[u32]) -> (Vec<DirectLight>, ShadowRays) {
        let (mut scratch, mut rays) = (Scratch::default(), ShadowRays::default());
        let direct = context.direct();
        let at = |&vertex: &u32| {
            let points = self.direct.points_of(vertex);
            if points.is_empty() || context.is_cancelled() {
                return DirectLight::default();
            }
            if self.coarse.is_some() {
                return mean(points.iter().map(|point| direct.at_point(point, &mut scratch, &mut rays)));
            }
            direct.at_vertex(vertex, points, &[], &mut scratch, &mut rays)
        };
        (vertices.iter().map(at).collect(), rays)
    }

    /// How many times as bright the area light is as that of the solve, if it is the same otherwise.
    fn brightness(&self, light: Option<&AreaLight>) -> Option<Vec3> {
        let frame = &self.problem.scene.frame;
        let before = self.problem.light?.to_local(frame);
        let now = *light?;
        let is_same = AreaLight { radiance: before.radiance, ..now } == before;
        let factor = now.radiance / before.radiance;
        (is_same && factor.is_finite()).then_some(factor)
    }

    /// Direct light, and all indirect light once it has converged.
    fn converged(
        &self,
        context: &Context,
        direct: Vec<Vec3>,
        weights: &VertexWeights,
        changes: Changes,
        report: &mut SolveReport,
    ) -> Vec<Arc<Vec<Vec3>>> {
        let direct = Arc::new(direct);
        report.energy.enter(&direct, weights);
        context.monitor.announce_bounce(0, &direct, report.energy.bounces[0]);
        if context.lights.is_empty() {
            return vec![direct];
        }
        let known = Some(&self.known).filter(|_| !changes.materials);
        let started = Instant::now() - Duration::from_secs_f64(report.seconds_following_direct);
        let show_on_the_way = |gathered: &[Vec3]| {
            if context.monitor.is_watched() && started.elapsed() > SHOWN_AFTER {
                let indirect = self.spread_light(gathered.to_vec());
                let total: Vec<Vec3> =
                    direct.iter().zip(&indirect).map(|(direct, indirect)| *direct + *indirect).collect();
                context.monitor.set_live(&total);
            }
        };
        let mut before_last = Vec::new();
        let mut last = Vec::new();
        let mut show = |gathered: Vec<Vec3>, report: &mut SolveReport| {
            report.iterations += 1;
            show_on_the_way(&gathered);
            before_last = std::mem::replace(&mut last, gathered);
        };
        if self.converge(context, &direct, known, &mut show, report).is_none() {
            return vec![direct];
        }
        let before_last = self.spread_light(before_last);
        let indirect = Arc::new(self.spread_light(last));
        let change: Vec<Vec3> = indirect.iter().zip(&before_last).map(|(now, before)| *now - *before).collect();
        report.energy.enter(&before_last, weights);
        report.energy.enter(&change, weights);
        context.monitor.announce_bounce(1, &indirect, report.energy.bounces[1]);
        vec![direct, indirect]
    }

    fn info_of(&self, problem: &Problem, changes: Changes, monitor: &Monitor) -> SolutionInfo {
        let known =
            self.info.clone().unwrap_or_else(|| crate::solver::solve::info(problem, &self.tessellation, monitor));
        let scene_hash = if changes.materials { problem.scene.hash() } else { known.scene_hash };
        SolutionInfo { light: problem.light, scene_hash, complete: !monitor.is_cancelled(), ..known }
    }
}
