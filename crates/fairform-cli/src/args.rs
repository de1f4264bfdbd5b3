//! The command line.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};
use fairform::interpolate::{Method, Norm};
use fairform::sphere::Ends;
use fairform::streamline::{Integration, MAX_DEPTH, Order};
use fairform::{Scheme, Vec3};
use fairform_io::Format;
use fairform_render::{Range, Show, View};

/// The heading of the options that every command has.
const GENERAL: &str = "General options";

/// Smooth subdivision surfaces through exactly the points you give.
///
/// Meshes are OBJ, OFF, PLY, STL, glTF or GLB, each also gzip-compressed, told apart by the file
/// name; `-` is standard input or output. Vertex i of the input stays vertex i of the output.
#[derive(Parser, Debug)]
#[command(name = "fairform", version, propagate_version = true, max_term_width = 100)]
#[command(
    after_help = "Exit codes: 0 done, 1 bad input or not converged, 2 wrong usage, 130 interrupted.\n\nExamples:\n  \
    fairform fit                               a sample: surface and picture\n  \
    fairform fit bunny.obj -o surface.ply      a surface through every vertex\n  \
    fairform info bunny.obj                    what is in a file, and wrong with it\n  \
    fairform render surface.ply -o surface.png"
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Say nothing but errors.
    #[arg(short, long, global = true, help_heading = GENERAL)]
    pub(crate) quiet: bool,
    /// Say more.
    #[arg(short, long, global = true, help_heading = GENERAL)]
    pub(crate) verbose: bool,
    /// Print the result as JSON on standard output.
    #[arg(long, global = true, help_heading = GENERAL)]
    pub(crate) json: bool,
    /// Number of threads; the result is the same for any. Default: one per core.
    #[arg(long, global = true, help_heading = GENERAL, value_name = "N", value_parser = threads)]
    pub(crate) threads: Option<NonZeroUsize>,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    Fit(Fit),
    Refine(Refine),
    Limit(Limit),
    Info(Info),
    Convert(Convert),
    Repair(Repair),
    Render(Box<Render>),
    Compare(Compare),
    Curve(Curve),
    Streamline(Streamline),
    Studio(Studio),
    /// Print a completion script for a shell.
    #[command(after_help = "Examples:\n  \
        fairform completions bash > ~/.bash_completion.d/fairform\n  \
        fairform completions fish > ~/.config/fish/completions/fairform.fish")]
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

/// Open the modeller in the browser.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "The page and the file are served to this machine alone, at an address that no other \
    page can guess, and no other host is asked for anything. Nothing is written to the file: the browser \
    saves where you say.\n\nExamples:\n  \
    fairform studio\n  \
    fairform studio bunny.obj\n  \
    fairform studio car.streamline.json --no-open"
)]
pub(crate) struct Studio {
    /// A mesh, a streamline model or a project of the studio to open.
    #[arg(value_name = "FILE")]
    pub(crate) input: Option<PathBuf>,
    /// Port to listen on; 0 takes a free one.
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub(crate) port: u16,
    /// Start no browser: only print the address.
    #[arg(long)]
    pub(crate) no_open: bool,
}

/// Find the surface that passes through every vertex of a mesh.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = "Finds the control mesh whose limit surface interpolates, refines it, and \
    writes the result. Without IN, a sample is fitted, and a picture of mesh and surface is drawn \
    too.\n\nExamples:\n  \
    fairform fit\n  \
    fairform fit bunny.obj -o surface.ply --limit\n  \
    fairform fit scan.ply -o surface.glb --tolerance 1e-9 --plot error.svg\n  \
    fairform fit cage.obj -o control.obj --levels 0 --report report.json\n  \
    fairform fit part.obj -o surface.obj --scheme catmull-clark --crease-angle 35 --limit\n  \
    cat bunny.off | fairform fit - --from off -o - --to ply > surface.ply")]
pub(crate) struct Fit {
    #[command(flatten)]
    pub(crate) input: MaybeInput,
    /// Where to write the surface.
    #[arg(short, long, value_name = "SURFACE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) writing: Writing,
    #[command(flatten)]
    pub(crate) scheme: SchemeOption,
    #[command(flatten)]
    pub(crate) rules: RuleOptions,
    /// Solver; all have the same answer. `auto` is the fastest that is safe on any mesh, `plain` the
    /// process as published [default: auto].
    #[arg(long, value_name = "auto|plain|weighted|chebyshev|cg|one-pass")]
    pub(crate) method: Option<Method>,
    /// Largest distance from a vertex to its limit point [default: 1e-6, unless --iterations is
    /// given].
    #[arg(long, value_name = "X", value_parser = positive)]
    pub(crate) tolerance: Option<f64>,
    /// What distances are divided by: the diagonal of the bounding box, its longest side, or nothing.
    #[arg(long, default_value_t = Norm::Diagonal, value_name = "diagonal|longest-side|absolute")]
    pub(crate) norm: Norm,
    /// Interpolate up to rounding, by a correction after one refinement step: the control mesh is then
    /// one level finer.
    #[arg(long)]
    pub(crate) exact: bool,
    /// Make the surface fairer while it keeps to the vertices, from 0 (as fitted) to 1 (fairest): for
    /// noisy or unevenly spaced points. Implies --exact.
    #[arg(long, value_name = "WEIGHT", value_parser = not_negative)]
    pub(crate) fair: Option<f64>,
    /// With --fair: what stretching counts beside bending. More makes a tighter surface.
    #[arg(long, value_name = "X", value_parser = not_negative, requires = "fair", default_value_t = 0.001)]
    pub(crate) fair_stretch: f64,
    /// Make exactly so many updates, or with --tolerance at most so many.
    #[arg(long, value_name = "K")]
    pub(crate) iterations: Option<u32>,
    /// Refinement steps of the surface; 0 writes the control mesh [default: 3].
    #[arg(long, value_name = "N")]
    pub(crate) levels: Option<u32>,
    /// Move the refined vertices onto the limit surface, and write exact normals.
    #[arg(long)]
    pub(crate) limit: bool,
    /// Also write the control mesh.
    #[arg(long, value_name = "CONTROL")]
    pub(crate) control: Option<PathBuf>,
    /// Also write what happened as JSON.
    #[arg(long, value_name = "R.json")]
    pub(crate) report: Option<PathBuf>,
    /// Also plot the error of every iteration.
    #[arg(long, value_name = "P.svg")]
    pub(crate) plot: Option<PathBuf>,
}

/// Refine a mesh by a subdivision scheme.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Vertices of the mesh keep their numbers. With Loop's and Catmull and Clark's \
    scheme up to five steps are made at once, without the meshes between: new vertices come edge by edge \
    and then face by face of the last mesh that was made, the faces of each of its faces one after the \
    other. Colours, normals and texture coordinates follow.\n\n\
    PLY, STL, OBJ, OFF and GLB are written while the mesh is made, so it may be larger than memory; but \
    not with a limit of creases, OBJ with seams of texture coordinates, or GLB with several \
    materials.\n\nExamples:\n  \
    fairform refine control.obj -o fine.obj --levels 2\n  \
    fairform refine control.obj -o limit.ply --levels 3 --limit\n  \
    fairform refine control.obj -o print.stl --levels 7 --limit\n  \
    fairform refine control.obj -o light.glb --levels 5 --adaptive 1e-4"
)]
pub(crate) struct Refine {
    #[command(flatten)]
    pub(crate) input: Input,
    /// Where to write the result.
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) writing: Writing,
    #[command(flatten)]
    pub(crate) scheme: SchemeOption,
    #[command(flatten)]
    pub(crate) rules: RuleOptions,
    /// Refinement steps.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub(crate) levels: u32,
    /// Move the vertices onto the limit surface, and write exact normals.
    #[arg(long)]
    pub(crate) limit: bool,
    /// Only as fine as it must be, and at most as fine as so many levels: no point of the limit surface is
    /// farther off than X diagonals of the bounding box. Implies --limit. For Loop and Catmull–Clark.
    #[arg(long, value_name = "X", value_parser = positive)]
    pub(crate) adaptive: Option<f64>,
    /// X of --adaptive is in distances from this point instead: on a screen of 1000 pixels and seen at
    /// about 50 degrees, a pixel is 0.001.
    #[arg(long, value_name = "X,Y,Z", requires = "adaptive", value_parser = point, allow_hyphen_values = true)]
    pub(crate) eye: Option<Vec3>,
}

/// Limit point and normal of every vertex of a control mesh.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Written as JSON {\"points\": […], \"normals\": […]} if OUT ends in .json, \
    otherwise as the mesh with its vertices at their limit points.\n\nExamples:\n  \
    fairform limit control.obj -o limit.json\n  \
    fairform limit control.obj -o limit.obj"
)]
pub(crate) struct Limit {
    #[command(flatten)]
    pub(crate) input: Input,
    /// Where to write the result.
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) writing: Writing,
    #[command(flatten)]
    pub(crate) scheme: SchemeOption,
    #[command(flatten)]
    pub(crate) rules: RuleOptions,
}

/// Say what is in a mesh file, and what is wrong with it.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  fairform info bunny.obj\n  fairform info scan.ply.gz --json\n  \
    fairform info cage.obj --scheme catmull-clark --crease-angle 35"
)]
pub(crate) struct Info {
    #[command(flatten)]
    pub(crate) input: Input,
    /// Also say whether a scheme, with the options below, suits the mesh, and what it makes of it.
    #[arg(long, value_name = "SCHEME")]
    pub(crate) scheme: Option<Scheme>,
    #[command(flatten)]
    pub(crate) rules: RuleOptions,
}

/// Write a mesh in another format.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Polygons, colours, normals, texture coordinates, groups and materials are \
    kept where the format has them; what it has not is said.\n\nExamples:\n  \
    fairform convert part.stl -o part.obj\n  \
    fairform convert bunny.obj -o bunny.ply.gz"
)]
pub(crate) struct Convert {
    #[command(flatten)]
    pub(crate) input: Input,
    /// Where to write the mesh.
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) writing: Writing,
}

/// Mend a mesh, step by step as asked for, and say what was done.
#[expect(clippy::struct_excessive_bools, reason = "one switch per option")]
#[derive(clap::Args, Debug)]
#[command(after_help = "The steps are made in the order in which they stand here, whatever their \
    order on the command line. `fairform info` tells which would help.\n\nExamples:\n  \
    fairform repair scan.ply -o clean.ply --weld 0 --orient --split\n  \
    fairform repair quads.obj -o triangles.obj --triangulate\n  \
    fairform repair broken.off -o sound.off --all")]
pub(crate) struct Repair {
    #[command(flatten)]
    pub(crate) input: Input,
    /// Where to write the mended mesh.
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) writing: Writing,
    /// Join vertices that are not farther apart than this; 0 joins equal positions only.
    #[arg(long, value_name = "EPS", value_parser = not_negative)]
    pub(crate) weld: Option<f64>,
    /// Drop faces with too few or repeated corners, or with vertices that do not exist.
    #[arg(long)]
    pub(crate) drop_degenerate: bool,
    /// Keep one of several faces with the same corners.
    #[arg(long)]
    pub(crate) drop_duplicates: bool,
    /// Turn faces so that neighbours agree.
    #[arg(long)]
    pub(crate) orient: bool,
    /// Give each fan of faces its own vertex where several meet in one, and part edges with more than
    /// two faces.
    #[arg(long)]
    pub(crate) split: bool,
    /// Close boundary loops of at most so many edges with triangles.
    #[arg(long, value_name = "EDGES")]
    pub(crate) fill_holes: Option<usize>,
    /// Turn closed surfaces that are inside out.
    #[arg(long)]
    pub(crate) outward: bool,
    /// Cut polygons into triangles.
    #[arg(long)]
    pub(crate) triangulate: bool,
    /// Drop vertices without a face.
    #[arg(long)]
    pub(crate) drop_isolated: bool,
    /// All that makes a manifold: --weld 0 --drop-degenerate --drop-duplicates --orient --split
    /// --drop-isolated.
    #[arg(long)]
    pub(crate) all: bool,
}

/// Draw meshes and streamline models side by side, without a window.
#[expect(clippy::struct_excessive_bools, reason = "one switch per option")]
#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:\n  \
    fairform render surface.ply -o surface.png\n  \
    fairform render bunny.obj surface.ply -o both.png --size 1600x800 --view front\n  \
    fairform render part.stl -o part.png --view 120,15,z --flat\n  \
    fairform render cage.obj surface.ply -o pair.png --flat=1 --wireframe=1\n  \
    fairform render surface.ply -o curvature.png --colour curvature\n  \
    fairform render cage.obj -o limit.png --scheme catmull-clark\n  \
    fairform render bunny.obj -o fitted.png --fit --draw-boundary\n  \
    fairform render car.streamline.json -o depths.png --view iso,z --depth 0,1,2,3\n  \
    fairform render car.streamline.json -o sphere.png --view iso,z --sphere")]
pub(crate) struct Render {
    /// Meshes or streamline models to draw, one panel each.
    #[arg(required = true, value_name = "IN")]
    pub(crate) inputs: Vec<PathBuf>,
    /// Format of the input files, if their names do not say.
    #[arg(long, value_name = "FORMAT")]
    pub(crate) from: Option<Format>,
    /// Where to write the picture.
    #[arg(short, long, value_name = "PICTURE.png")]
    pub(crate) output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "1200x900", value_name = "WxH", value_parser = size)]
    pub(crate) size: (u32, u32),
    /// front, back, left, right, top, bottom, iso, or AZIMUTH,ELEVATION in degrees; with ",z" if z is
    /// up [default: the `display.view` of the first model that has one, else iso].
    #[arg(long, allow_hyphen_values = true)]
    pub(crate) view: Option<View>,
    /// Magnify.
    #[arg(long, default_value_t = 1.0, value_parser = positive)]
    pub(crate) zoom: f64,
    /// Draw the edges; in some panels only with =1,3.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "all", value_name = "PANELS", value_parser = panels)]
    pub(crate) wireframe: Option<Panels>,
    /// Draw the vertices; in some panels only with =1,3.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "all", value_name = "PANELS", value_parser = panels)]
    pub(crate) points: Option<Panels>,
    /// Draw the boundary in red; in some panels only with =1,3.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "all", value_name = "PANELS", value_parser = panels)]
    pub(crate) draw_boundary: Option<Panels>,
    /// One shade per face; in some panels only with =1,3.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "all", value_name = "PANELS", value_parser = panels)]
    pub(crate) flat: Option<Panels>,
    /// Colour the surfaces: by mean curvature (curvature, mean), gaussian curvature, distance to the
    /// mesh of --reference (error), shape parameters (tension); or let them mirror stripes (zebra) or
    /// lamps (reflection).
    #[arg(long, visible_alias = "color", value_enum)]
    pub(crate) colour: Option<ColourChoice>,
    /// What the colours span: auto (2nd to 98th percentile), full, 5%..95%, or numbers as in -1..1.
    #[arg(long, default_value = "auto", allow_hyphen_values = true)]
    pub(crate) range: Range,
    /// Draw the limit surface that this scheme makes of each mesh.
    #[arg(long, value_name = "SCHEME")]
    pub(crate) scheme: Option<Scheme>,
    /// Draw the surface through every vertex of each mesh, as `fairform fit` finds it [scheme: loop,
    /// unless --scheme says another].
    #[arg(long)]
    pub(crate) fit: bool,
    /// With --fit: interpolate up to rounding.
    #[arg(long, requires = "fit")]
    pub(crate) exact: bool,
    /// With --fit: make the surface fairer, from 0 to 1.
    #[arg(long, value_name = "WEIGHT", value_parser = not_negative, requires = "fit")]
    pub(crate) fair: Option<f64>,
    /// Refinement steps for --scheme and --fit [default: 3].
    #[arg(long, value_name = "N")]
    pub(crate) levels: Option<u32>,
    #[command(flatten)]
    pub(crate) rules: RuleOptions,
    /// The mesh that --colour error measures against.
    #[arg(long, value_name = "MESH")]
    pub(crate) reference: Option<PathBuf>,
    /// A line of text below each panel, in order; repeat it for each.
    #[arg(long, value_name = "TEXT")]
    pub(crate) title: Vec<String>,
    /// Leave the background transparent.
    #[arg(long)]
    pub(crate) transparent: bool,
    /// Fit the camera to each panel alone, not to all of them.
    #[arg(long)]
    pub(crate) separate: bool,
    #[command(flatten)]
    pub(crate) model: ModelOptions,
}

/// What to draw of models (`*.streamline.json`).
#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Streamline models (*.streamline.json)")]
pub(crate) struct ModelOptions {
    /// Refine so many times, whatever the file says; several, as in 0,1,2,3, have a panel each.
    #[arg(long, value_name = "N,…", value_delimiter = ',')]
    pub(crate) depth: Vec<u32>,
    /// What to draw, of surface, streamlines, across (lines across these), arrows (control tangents),
    /// refined (tangents), initial (curve), start (points on it), combs (of curvature)
    /// [default: surface,streamlines,arrows,initial].
    #[arg(long, value_name = "WHAT,…", value_delimiter = ',', conflicts_with = "sphere")]
    pub(crate) show: Vec<Show>,
    /// Draw the tangents on the Gaussian sphere instead: those of all streamlines, of some, as in
    /// =0,2, or across them (=columns).
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "rows", value_name = "ROWS", value_parser = sphere)]
    pub(crate) sphere: Option<Sphere>,
}

/// Which tangents to draw on the Gaussian sphere.
#[derive(Clone, Debug)]
pub(crate) enum Sphere {
    Rows,
    Columns,
    /// Counted from 0, as in the file.
    Some(Vec<usize>),
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum ColourChoice {
    Curvature,
    Mean,
    Gaussian,
    Error,
    Tension,
    Zebra,
    Reflection,
}

/// Which panels of a picture.
#[derive(Clone, Debug)]
pub(crate) enum Panels {
    All,
    /// Counted from 1.
    Some(Vec<usize>),
}

impl TensionOptions {
    /// Whether any option speaks of shape parameters.
    pub(crate) fn is_given(&self) -> bool {
        self.lambda.is_some() || !self.tension_where.is_empty()
    }
}

impl Panels {
    /// Whether panel `i`, counted from 0, is one of them.
    pub(crate) fn has(choice: Option<&Self>, i: usize) -> bool {
        match choice {
            None => false,
            Some(Self::All) => true,
            Some(Self::Some(panels)) => panels.contains(&(i + 1)),
        }
    }
}

/// Run all schemes on a mesh: a table of error, fairness and time, and a sheet of pictures.
#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:\n  \
    fairform compare cage.obj\n  \
    fairform compare bunny.obj -o sheet.png --view front")]
pub(crate) struct Compare {
    #[command(flatten)]
    pub(crate) input: Input,
    /// Where to write the pictures, if at all.
    #[arg(short, long, value_name = "SHEET.png")]
    pub(crate) output: Option<PathBuf>,
    /// Refinement steps of the surfaces that are measured.
    #[arg(long, default_value_t = 3, value_name = "N")]
    pub(crate) levels: u32,
    /// Width and height in pixels.
    #[arg(long, default_value = "1800x1400", value_name = "WxH", value_parser = size)]
    pub(crate) size: (u32, u32),
    /// front, back, left, right, top, bottom, iso, or AZIMUTH,ELEVATION in degrees; with ",z" if z is
    /// up.
    #[arg(long, default_value = "iso", allow_hyphen_values = true)]
    pub(crate) view: View,
}

/// Refine and integrate a curve of tangents.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "SPEC is JSON: a scheme (chaikin, cubic, four-point, or qi for a QI curve) and unit \
    tangents; the guide describes all fields. OUT.json gets the refined tangents, their parameters \
    and the points; OUT.obj the points as a polyline.\n\nExamples:\n  \
    fairform curve spec.json -o curve.json\n  \
    fairform curve spec.json -o curve.obj --depth 5\n  \
    echo '{\"scheme\": \"qi\", \"tangents\": [[1,0,0], [0,1,0]], \"order\": 2, \"length\": 1, \
    \"samples\": 9}' | fairform curve - -o arc.json"
)]
pub(crate) struct Curve {
    /// The curve to read; - is standard input.
    #[arg(value_name = "SPEC.json")]
    pub(crate) input: PathBuf,
    /// Where to write the result: .json or .obj; - is standard output.
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Refinement steps, instead of those in the file.
    #[arg(long, value_name = "N", value_parser = depth())]
    pub(crate) depth: Option<u32>,
}

/// Make a surface of streamlines: a grid of tangents, refined and integrated.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "MODEL is JSON; the guide describes it, and --new writes one to begin with. \
    SURFACE is a mesh of quadrilaterals with (s, t) as texture coordinates; or, if it ends in .json, \
    the refined tangents, parameters and points; or, if it ends in .streamline.json, the model itself \
    with the options applied. Where the last streamline of a patch is the first of the next, to 1e-12 \
    of the diagonal, they share its vertices; where that of the last is the first of all, the surface \
    is closed.\n\nExamples:\n  \
    fairform streamline --new wave -o wave.streamline.json\n  \
    fairform streamline wave.streamline.json -o wave.ply\n  \
    fairform streamline wave.streamline.json -o fine.glb --depth 5 --integration arcs\n  \
    fairform streamline wave.streamline.json --stats\n  \
    fairform streamline wave.streamline.json --swap 9x7 -o across.streamline.json\n  \
    fairform streamline wave.streamline.json --bspline 1e-4 -o wave.obj"
)]
#[group(skip)]
pub(crate) struct Streamline {
    /// The model to read, also gzip-compressed; - is standard input.
    #[arg(value_name = "MODEL.json", required_unless_present = "new")]
    pub(crate) input: Option<PathBuf>,
    /// Begin with a new model instead: flat, arc and wave are small, car is an example.
    #[arg(long, value_enum, conflicts_with = "input")]
    pub(crate) new: Option<Starter>,
    /// Where to write the surface.
    #[arg(short, long, value_name = "SURFACE", required_unless_present = "stats")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) writing: Writing,
    /// Refinement steps, instead of those in the model, as all that follows.
    #[arg(long, value_name = "N", value_parser = depth())]
    pub(crate) depth: Option<u32>,
    /// Subdivision scheme.
    #[arg(long, value_enum)]
    pub(crate) scheme: Option<TangentScheme>,
    /// Refine along the streamlines first (st), or across (ts).
    #[arg(long, value_enum)]
    pub(crate) order: Option<OrderChoice>,
    /// Let the borders shrink as the scheme does by itself, or keep them.
    #[arg(long, value_enum)]
    pub(crate) ends: Option<EndsChoice>,
    /// Kobbelt's tension.
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub(crate) w: Option<f64>,
    /// Integrate straight from the middle between tangents to the next, or along circular arcs.
    #[arg(long, value_enum)]
    pub(crate) integration: Option<IntegrationChoice>,
    /// Exchange the roles of s and t: the surface by streamlines that run across those of the model, so
    /// many and with so many tangents each, taken from its refined surface, to which they are near.
    #[arg(long, value_name = "ROWSxCOLUMNS", value_parser = grid)]
    pub(crate) swap: Option<[usize; 2]>,
    /// Write a bicubic B-spline surface instead, one for each patch, within this fraction of the
    /// diagonal of the bounding box of the surface, which is refined by arcs until it can be told: as a
    /// free-form surface if SURFACE ends in .obj, as degrees, knots and control points if in .json.
    #[arg(long, value_name = "TOLERANCE", value_parser = positive, requires = "output")]
    pub(crate) bspline: Option<f64>,
    /// Also say lengths, curvature along the streamlines, bending energy, and how well patches join.
    #[arg(long)]
    pub(crate) stats: bool,
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Starter {
    Flat,
    Arc,
    Wave,
    Car,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
pub(crate) enum TangentScheme {
    DooSabin,
    CatmullClark,
    Kobbelt,
}

impl From<TangentScheme> for Scheme {
    fn from(choice: TangentScheme) -> Self {
        match choice {
            TangentScheme::DooSabin => Self::DooSabin,
            TangentScheme::CatmullClark => Self::CatmullClark,
            TangentScheme::Kobbelt => Self::Kobbelt,
        }
    }
}

#[derive(ValueEnum, Clone, Copy, Debug)]
pub(crate) enum OrderChoice {
    St,
    Ts,
}

impl From<OrderChoice> for Order {
    fn from(choice: OrderChoice) -> Self {
        match choice {
            OrderChoice::St => Self::St,
            OrderChoice::Ts => Self::Ts,
        }
    }
}

#[derive(ValueEnum, Clone, Copy, Debug)]
pub(crate) enum EndsChoice {
    Natural,
    Clamped,
}

impl From<EndsChoice> for Ends {
    fn from(choice: EndsChoice) -> Self {
        match choice {
            EndsChoice::Natural => Self::Natural,
            EndsChoice::Clamped => Self::Clamped,
        }
    }
}

#[derive(ValueEnum, Clone, Copy, Debug)]
pub(crate) enum IntegrationChoice {
    Midpoint,
    Arcs,
}

impl From<IntegrationChoice> for Integration {
    fn from(choice: IntegrationChoice) -> Self {
        match choice {
            IntegrationChoice::Midpoint => Self::Midpoint,
            IntegrationChoice::Arcs => Self::Arcs,
        }
    }
}

/// A mesh to read.
#[derive(clap::Args, Debug)]
pub(crate) struct Input {
    /// The mesh to read; - is standard input.
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// Format of the input, if its name does not say: obj, off, ply, stl, gltf, glb.
    #[arg(long, value_name = "FORMAT")]
    pub(crate) from: Option<Format>,
}

/// A mesh to read, or the sample.
#[derive(clap::Args, Clone, Debug)]
#[group(skip)]
pub(crate) struct MaybeInput {
    /// The mesh to read; - is standard input. Without it, a sample.
    #[arg(value_name = "IN", requires = "output")]
    pub(crate) input: Option<PathBuf>,
    /// Format of the input, if its name does not say: obj, off, ply, stl, gltf, glb.
    #[arg(long, value_name = "FORMAT")]
    pub(crate) from: Option<Format>,
}

/// How to write a mesh.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct Writing {
    /// Format of the output, if its name does not say: obj, off, ply, stl, gltf, glb.
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Option<Format>,
    /// Write PLY and STL as text.
    #[arg(long)]
    pub(crate) ascii: bool,
    /// Round numbers to 32 bits where the format has a choice.
    #[arg(long)]
    pub(crate) single: bool,
}

/// Shape parameters of faces.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct TensionOptions {
    /// The first step in two phases, with a shape parameter per face: near 1 tight, around 0.5 round.
    /// From 0.5 to 1 for Loop and Catmull–Clark, above 0 for Doo–Sabin, which also knows auto. A
    /// number or a JSON file.
    #[arg(long, visible_alias = "tension", value_name = "X|auto|FILE.json")]
    pub(crate) lambda: Option<String>,
    /// Another parameter for some faces, for example 'group=lid':0.85 or 'z>0.5 and not part=1':0.9;
    /// repeat it for more, later ones win.
    #[arg(long, value_name = "SELECTION:X", value_parser = selection)]
    pub(crate) tension_where: Vec<(String, f64)>,
    /// Let --tension-where fade over this distance from the selection outward.
    #[arg(long, value_name = "DISTANCE", value_parser = positive)]
    pub(crate) falloff: Option<f64>,
}

/// The subdivision scheme.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct SchemeOption {
    /// Subdivision scheme: loop for triangles, catmull-clark or doo-sabin for any polygons; butterfly
    /// (triangles) and kobbelt (quadrilaterals) pass through the vertices by themselves [default: loop, or
    /// what a project says].
    #[arg(long, value_name = "SCHEME")]
    pub(crate) scheme: Option<Scheme>,
}

impl SchemeOption {
    pub(crate) fn chosen(&self) -> Scheme {
        self.scheme.unwrap_or(Scheme::Loop)
    }
}

/// The choices that schemes have; every command that knows schemes takes them all.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct RuleOptions {
    /// Boundary vertices with one face: rounded like others, or kept [default: smooth, unless the
    /// file says otherwise; for kobbelt sharp].
    #[arg(long, value_enum)]
    pub(crate) corners: Option<CornerChoice>,
    /// Kobbelt's tension [default: 1].
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub(crate) w: Option<f64>,
    /// The boundary of the surface: a B-spline of the boundary of the mesh; or none, faces at the boundary
    /// being support without a surface (as OpenSubdiv has it); or, for doo-sabin, dropped [default:
    /// bspline, unless the file says otherwise].
    #[arg(long, value_enum)]
    pub(crate) boundary: Option<BorderChoice>,
    #[command(flatten)]
    pub(crate) tension: TensionOptions,
    /// Sharp edges and vertices, holes: JSON as in USD, or the `t` lines of an OBJ file; or none. Default:
    /// the `t` lines of the mesh, if it has any.
    #[arg(long, value_name = "FILE|none")]
    pub(crate) creases: Option<PathBuf>,
    /// Make edges sharp whose faces meet at more than this angle.
    #[arg(long, value_name = "DEGREES", value_parser = not_negative)]
    pub(crate) crease_angle: Option<f64>,
}

impl RuleOptions {
    /// The name of a choice that was made besides shape parameters, if any.
    pub(crate) fn made(&self) -> Option<&'static str> {
        [
            (self.corners.is_some(), "--corners"),
            (self.w.is_some(), "--w"),
            (self.boundary.is_some(), "--boundary"),
            (self.creases.is_some(), "--creases"),
            (self.crease_angle.is_some(), "--crease-angle"),
        ]
        .into_iter()
        .find_map(|(made, name)| made.then_some(name))
    }
}

#[derive(ValueEnum, Clone, Copy, Debug)]
pub(crate) enum BorderChoice {
    Bspline,
    Drop,
    None,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
pub(crate) enum CornerChoice {
    Smooth,
    Sharp,
}

fn depth() -> clap::builder::RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(0..=i64::from(MAX_DEPTH))
}

fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let number = text.parse().ok().filter(|n: &NonZeroUsize| n.get() <= 1024);
    number.ok_or_else(|| "expected a number from 1 to 1024".into())
}

fn selection(text: &str) -> Result<(String, f64), String> {
    let (selection, value) =
        text.rsplit_once(':').ok_or("expected SELECTION:X, for example 'group=lid':0.85")?;
    Ok((selection.into(), positive(value)?))
}

fn positive(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0, "a positive number")
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |x| x >= 0.0, "a number that is not negative")
}

fn point(text: &str) -> Result<Vec3, String> {
    let expected = "expected three numbers, such as 0,-2.5,1";
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|one| one.trim().parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err(expected.into()),
    }
}

fn number(text: &str, ok: fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| x.is_finite() && ok(*x));
    number.ok_or_else(|| format!("expected {expected}"))
}

fn panels(text: &str) -> Result<Panels, String> {
    if text == "all" {
        return Ok(Panels::All);
    }
    let panel = |one: &str| one.trim().parse().ok().filter(|&n: &usize| n > 0);
    let panels = text.split(',').map(panel).collect::<Option<_>>();
    panels.map(Panels::Some).ok_or_else(|| "expected panel numbers from 1, as in 1,3".into())
}

fn sphere(text: &str) -> Result<Sphere, String> {
    match text {
        "rows" => Ok(Sphere::Rows),
        "columns" => Ok(Sphere::Columns),
        _ => {
            let rows = text.split(',').map(|one| one.trim().parse().ok()).collect::<Option<_>>();
            rows.map(Sphere::Some)
                .ok_or_else(|| "expected rows, columns or numbers, as in 0,2".into())
        }
    }
}

fn grid(text: &str) -> Result<[usize; 2], String> {
    let parse = || {
        let (rows, columns) = text.split_once(['x', 'X', '×'])?;
        Some([rows.trim().parse().ok()?, columns.trim().parse().ok()?])
    };
    let fits = |size: &[usize; 2]| size.iter().all(|n| (2..1 << 20).contains(n));
    parse()
        .filter(fits)
        .ok_or_else(|| "expected ROWSxCOLUMNS, at least 2 of each, for example 9x7".into())
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let parse = || {
        let (w, h) = text.split_once(['x', 'X', '×'])?;
        Some((w.trim().parse().ok()?, h.trim().parse().ok()?))
    };
    parse().ok_or_else(|| "expected WIDTHxHEIGHT, for example 1200x900".into())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Args::command().debug_assert();
    }
}
