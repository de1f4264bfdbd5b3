//! Dragging vertices: what moves, and only that.

use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use fairform::edit::{Drag, Editor};
use fairform::interpolate::{Interpolator, Options, fit_mesh};
use fairform::pushback::PushBack;
use fairform::tessellate::{Part, Tessellation};
use fairform::{FaceId, Topology, Vec3, VertexId, refine};

use crate::Problem;
use crate::drawing::single;
use crate::mesh_session::{Drawn, Fitted, MeshSession};

/// What a drag moved.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct DragAnswer {
    /// The points of the surface, as last drawn, that moved; none means all.
    pub vertices: Option<Vec<u32>>,
    /// Where they are.
    pub positions: Vec<[f32; 3]>,
    /// Their normals.
    pub normals: Vec<[f32; 3]>,
    /// The control points that moved.
    pub control_vertices: Vec<u32>,
    /// Where they are.
    pub control_positions: Vec<[f32; 3]>,
}

/// What the end of a drag leaves.
#[derive(Clone, PartialEq, Debug)]
pub struct Released {
    /// All vertices that are not where the file has them, and where they are.
    pub moves: Vec<(u32, f64, f64, f64)>,
    /// Largest distance of the surface from a vertex, relative to the diagonal.
    pub max: f64,
    /// What moved since the last answer.
    pub answer: DragAnswer,
}

/// Vertices that are being dragged.
#[derive(Debug)]
pub(crate) struct Grabbed {
    how: How,
    vertices: Vec<VertexId>,
    /// How far they are from where they were grabbed.
    offset: Vec3,
    moving: Moving,
    /// Whether all of the surface is told next: it is not what was last drawn.
    all: bool,
}

/// How control points follow.
#[derive(Debug)]
enum How {
    /// By a column that was solved for once.
    Column(Box<(Editor, Drag)>),
    /// By fitting again, where that is all there is.
    Again,
}

/// The part of a surface that depends on what is dragged.
#[derive(Debug, Default)]
struct Moving {
    /// Points that lie one behind the other.
    parts: Vec<Part>,
    /// The numbers of all of them.
    vertices: Vec<u32>,
    /// Control points.
    control: Vec<u32>,
}

/// Points or faces that do not move are told too where they are so few between those that do.
const GAP: usize = 4;

/// Numbers, ascending, as ranges.
fn ranges(numbers: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for number in numbers {
        match ranges.last_mut() {
            Some(last) if number <= last.end + GAP => last.end = number + 1,
            _ => ranges.push(number..number + 1),
        }
    }
    ranges
}

impl Moving {
    /// The part that belongs to some faces of the given mesh.
    ///
    /// Of a face that does not move, nothing on its outline does; so the points on edges move only where
    /// the first face of the edge does, which are those that [`Part::Sides`] has.
    fn new(fine: &Tessellation, origin: &[u32], faces: &[FaceId], control: Vec<u32>) -> Self {
        let base = fine.base();
        let is_moved = |f: &u32| faces.binary_search(&FaceId(*f)).is_ok();
        let moved = || (0..origin.len()).filter(|&f| is_moved(&origin[f]));
        let on = moved().flat_map(|f| base.face_vertices(FaceId(f as u32)));
        let mut corners: Vec<usize> = on.map(|v| v.index()).collect();
        corners.sort_unstable();
        corners.dedup();
        let mut parts: Vec<Part> =
            ranges(corners.into_iter()).into_iter().map(Part::Vertices).collect();
        if fine.has_grids() {
            for run in ranges(moved()) {
                parts.extend([Part::Sides(run.clone()), Part::Inside(run)]);
            }
        }
        parts.retain(|part| !fine.numbers_of(part).is_empty());
        let vertices = parts.iter().flat_map(|part| fine.numbers_of(part)).map(|v| v as u32);
        Self { vertices: vertices.collect(), parts, control }
    }

    /// Where its points are.
    fn points(&self, fine: &Tessellation, control: &[Vec3]) -> Result<[Vec<[f32; 3]>; 2], Problem> {
        let surface = fine.surface(control)?;
        let mut positions = vec![[0.0; 3]; self.vertices.len()];
        let mut normals = positions.clone();
        let (mut p, mut n) = (&mut positions[..], &mut normals[..]);
        for part in &self.parts {
            let count = fine.numbers_of(part).len();
            let (own, rest) = p.split_at_mut(count);
            let (own_normals, rest_normals) = n.split_at_mut(count);
            surface.fill_part(part, own, Some(own_normals));
            (p, n) = (rest, rest_normals);
        }
        Ok([positions, normals])
    }
}

impl MeshSession {
    /// Begins to drag vertices of the given mesh together.
    ///
    /// # Errors
    /// If there is no such vertex, or no surface yet.
    pub fn grab(&mut self, vertices: &[u32]) -> Result<(), Problem> {
        let kept = self.editor.take();
        let (fitted, drawn) = self.drawn()?;
        let topology = Arc::clone(fitted.target.topology());
        let count = topology.vertex_count();
        if let Some(v) = vertices.iter().find(|v| **v as usize >= count) {
            return Err(Problem::new(format!("there is no vertex {v}: the mesh has {count}")));
        }
        let mut vertices: Vec<VertexId> = vertices.iter().map(|&v| VertexId(v)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let editor = kept.or_else(|| fitted.editor());
        let grabbed = editor.and_then(|editor| {
            let drag = editor.grab(&vertices).ok()?;
            Some((editor, drag))
        });
        let is_last = drawn.iteration.is_none();
        let (how, moving) = match grabbed {
            None => (How::Again, Moving::default()),
            Some((editor, drag)) => {
                let changed = drag.changed();
                let control = match fitted.level {
                    0 => changed.vertices.iter().map(|v| v.0).collect(),
                    _ => fitted.finer_vertices(changed.faces)?,
                };
                let moving = match is_last {
                    true => Moving::new(&drawn.fine, &drawn.origin, changed.faces, control),
                    false => Moving { control, ..Moving::default() },
                };
                (How::Column(Box::new((editor, drag))), moving)
            }
        };
        // A surface one level down is not that of the control points that follow, but for rounding or
        // fairness.
        let all = fitted.level > 0 || !is_last || matches!(how, How::Again);
        self.grabbed = Some(Grabbed { how, vertices, offset: Vec3::ZERO, moving, all });
        Ok(())
    }

    /// Where the surface is with the grabbed vertices at `offset` from where they were grabbed.
    ///
    /// # Errors
    /// If nothing is grabbed, or the offset is not finite.
    pub fn drag(&mut self, offset: Vec3) -> Result<DragAnswer, Problem> {
        if !offset.is_finite() {
            return Err(Problem::new("the offset of a drag is not finite"));
        }
        let Some(mut grabbed) = self.grabbed.take() else {
            return Err(Problem::new("no vertices are grabbed").help("grab some first"));
        };
        let answer = self.drag_to(&mut grabbed, offset);
        self.grabbed = Some(grabbed);
        answer
    }

    fn drag_to(&mut self, grabbed: &mut Grabbed, offset: Vec3) -> Result<DragAnswer, Problem> {
        let step = offset - grabbed.offset;
        let fitted = self.fitted.as_mut().ok_or_else(|| Problem::new("there is no surface"))?;
        let control = match &mut grabbed.how {
            How::Column(column) => {
                let (editor, drag) = &mut **column;
                editor.drag(drag, step);
                fitted.target = fitted.target.with_positions(editor.target().to_vec());
                fitted.control_of(editor)?
            }
            How::Again => {
                let mut positions = fitted.target.positions().to_vec();
                grabbed.vertices.iter().for_each(|v| positions[v.index()] += step);
                fitted.target = fitted.target.with_positions(positions);
                fitted.fit_again()?.0
            }
        };
        grabbed.offset = offset;
        self.mesh = fitted.target.clone();
        fitted.control = fitted.control.with_positions(control);
        let all = std::mem::take(&mut grabbed.all) || matches!(grabbed.how, How::Again);
        self.moved((!all).then_some(&grabbed.moving))
    }

    /// Takes the control points over into the drawing, and tells where a part of it is, or all of it.
    fn moved(&mut self, moving: Option<&Moving>) -> Result<DragAnswer, Problem> {
        let (Some(fitted), Some(drawn)) = (&self.fitted, &mut self.drawn) else {
            return Err(Problem::new("no surface has been drawn yet"));
        };
        if drawn.iteration.take().is_some() {
            *drawn = fitted.draw(drawn.fineness, None)?;
        }
        drawn.control.clear();
        drawn.control.extend_from_slice(fitted.control.positions());
        let control = &drawn.control;
        let Some(moving) = moving else {
            let [positions, normals] = drawn.all_points()?;
            let control_vertices = (0..control.len() as u32).collect();
            let control_positions = single(control);
            let vertices = None;
            return Ok(DragAnswer {
                vertices,
                positions,
                normals,
                control_vertices,
                control_positions,
            });
        };
        let [positions, normals] = moving.points(&drawn.fine, control)?;
        Ok(DragAnswer {
            vertices: Some(moving.vertices.clone()),
            positions,
            normals,
            control_vertices: moving.control.clone(),
            control_positions: moving.control.iter().map(|&v| control[v as usize].into()).collect(),
        })
    }

    /// Ends the drag and settles: the surface passes through every vertex again.
    ///
    /// # Errors
    /// If nothing is grabbed; if the vertices are where no surface passes through them.
    pub fn release(&mut self) -> Result<Released, Problem> {
        let Some(grabbed) = self.grabbed.take() else {
            return Err(Problem::new("no vertices are grabbed").help("grab some first"));
        };
        let fitted = self.fitted.as_mut().ok_or_else(|| Problem::new("there is no surface"))?;
        let (control, max) = match grabbed.how {
            How::Column(column) => {
                let mut editor = column.0;
                let (largest, _) = editor.settle()?;
                let settled = match fitted.level {
                    0 => (editor.control().to_vec(), largest / fitted.unit),
                    _ => fitted.fit_again()?,
                };
                self.editor = Some(editor);
                settled
            }
            How::Again => fitted.fit_again()?,
        };
        fitted.control = fitted.control.with_positions(control);
        fitted.design.moves = moves(&self.data.positions, fitted.target.positions());
        let moves = fitted.design.moves.clone();
        self.mesh = fitted.target.clone();
        let answer = self.moved(None)?;
        Ok(Released { moves, max, answer })
    }
}

/// The vertices that are not where the file has them.
fn moves(given: &[Vec3], now: &[Vec3]) -> Vec<(u32, f64, f64, f64)> {
    let moved = (0..).zip(given.iter().zip(now)).filter(|(_, (p, q))| p != q);
    moved.map(|(v, (_, q))| (v, q.x, q.y, q.z)).collect()
}

impl Fitted {
    /// An editor of control points of level 0; none where there are none, or they do not follow.
    fn editor(&self) -> Option<Editor> {
        let tolerance = self.design.tolerance.clamp(1e-12, 0.1);
        let control = if self.level == 0 {
            self.control.positions().to_vec()
        } else {
            let (topology, positions) = (self.target.topology(), self.target.positions());
            let options = Options { tolerance: Some(tolerance), ..Options::default() };
            let mut go_on = |_, _| ControlFlow::Continue(());
            let interpolator = Interpolator::near(topology, &self.rules, positions).ok()?;
            interpolator.fit(positions, &options, &mut go_on).ok()?.0
        };
        Editor::new(&self.target, &self.rules, control, tolerance).ok()
    }

    /// The control points, as fine as those of the fit, that the control points of an editor lead to.
    fn control_of(&self, editor: &Editor) -> Result<Vec<Vec3>, Problem> {
        if self.level == 0 {
            return Ok(editor.control().to_vec());
        }
        let pushback = PushBack::new(self.target.topology(), &self.rules)?;
        let mut finer = pushback.step().apply(editor.control());
        pushback.correct(editor.target(), &mut finer);
        Ok(finer)
    }

    /// The control points for the vertices as they are now, and the largest distance.
    fn fit_again(&self) -> Result<(Vec<Vec3>, f64), Problem> {
        let mut go_on = |_, _| ControlFlow::Continue(());
        let fit = fit_mesh(&self.target, &self.rules, &self.design.options(), &mut go_on)?;
        if fit.level != self.level {
            return Err(Problem::new(
                "with the vertices there, no control mesh of this level interpolates them",
            )
            .help("fit again"));
        }
        Ok((fit.control.into_positions(), fit.report.max))
    }

    /// The finer vertices on some faces of the target.
    fn finer_vertices(&self, faces: &[FaceId]) -> Result<Vec<u32>, Problem> {
        let step = refine::refine(self.target.topology(), &self.rules)?;
        let finer: &Topology = &step.topology;
        let on = finer.faces().filter(|&f| faces.binary_search(&step.parent(f)).is_ok());
        let mut vertices: Vec<u32> = on.flat_map(|f| finer.face_vertices(f)).map(|v| v.0).collect();
        vertices.sort_unstable();
        vertices.dedup();
        Ok(vertices)
    }
}

impl Drawn {
    /// All points and normals.
    fn all_points(&self) -> Result<[Vec<[f32; 3]>; 2], Problem> {
        let surface = self.fine.surface(&self.control)?;
        let mut positions = vec![[0.0; 3]; self.fine.vertex_count()];
        let mut normals = positions.clone();
        surface.fill(&mut positions, Some(&mut normals));
        Ok([positions, normals])
    }
}
