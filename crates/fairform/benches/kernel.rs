//! What does each step of the straight line cost per vertex? A torus of 10 000 and of 160 000
//! vertices, and of 2 560 000 if `FAIRFORM_BENCH_LARGE` is set.
//!
//! `cargo bench --package fairform -- refine` runs a part of it and compares with the last time;
//! `cargo xtask bench` makes a table beside what memory allows.

use std::hint::black_box;
use std::ops::ControlFlow;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fairform::interpolate::{Interpolator, Method, Options};
use fairform::{Mesh, Rules, Topology, Vec3, limit, refine, shapes};

fn meshes() -> Vec<Mesh> {
    let large = std::env::var_os("FAIRFORM_BENCH_LARGE").is_some();
    let sides: &[u32] = if large { &[100, 400, 1600] } else { &[100, 400] };
    sides.iter().map(|&side| shapes::torus(side, side)).collect()
}

/// Elements are the vertices of the mesh.
fn topology(c: &mut Criterion) {
    let mut group = c.benchmark_group("topology");
    for mesh in meshes() {
        let (count, faces) = (mesh.positions().len(), mesh.topology().to_faces());
        group.throughput(Throughput::Elements(count as u64));
        group.bench_with_input(BenchmarkId::from_parameter(count), &faces, |b, faces| {
            b.iter(|| Topology::from_faces(count, faces).expect("a torus is a manifold"));
        });
    }
}

/// Elements are the vertices that the step makes.
fn refinement(c: &mut Criterion) {
    let mut group = c.benchmark_group("refine");
    for mesh in meshes() {
        let count = mesh.positions().len();
        let step = refine::refine(mesh.topology(), &Rules::LOOP).expect("triangles");
        group.throughput(Throughput::Elements((count + mesh.topology().edge_count()) as u64));
        group.bench_with_input(BenchmarkId::new("topology", count), &mesh, |b, mesh| {
            b.iter(|| refine::refine(mesh.topology(), &Rules::LOOP).expect("triangles").topology);
        });
        group.bench_with_input(BenchmarkId::new("positions", count), &mesh, |b, mesh| {
            b.iter(|| step.apply(mesh.positions()));
        });
    }
}

/// Elements are the vertices of the mesh.
fn limits(c: &mut Criterion) {
    let mut group = c.benchmark_group("limit");
    for mesh in meshes() {
        let count = mesh.positions().len();
        group.throughput(Throughput::Elements(count as u64));
        group.bench_with_input(BenchmarkId::new("points", count), &mesh, |b, mesh| {
            b.iter(|| limit::limit_points(mesh.topology(), mesh.positions(), &Rules::LOOP));
        });
        group.bench_with_input(BenchmarkId::new("normals", count), &mesh, |b, mesh| {
            b.iter(|| limit::limit_normals(mesh.topology(), mesh.positions(), &Rules::LOOP));
        });
    }
}

/// Preparing, and a whole fit to 1e-6. Elements are the vertices of the mesh.
fn fits(c: &mut Criterion) {
    let mut group = c.benchmark_group("fit");
    for mesh in meshes() {
        let count = mesh.positions().len();
        group.throughput(Throughput::Elements(count as u64));
        group.bench_with_input(BenchmarkId::new("prepare", count), &mesh, |b, mesh| {
            b.iter(|| prepare(mesh));
        });
        let interpolator = prepare(&mesh);
        for method in Method::ALL {
            let options = Options { method, ..Options::default() };
            group.bench_with_input(BenchmarkId::new(method.name(), count), &mesh, |b, mesh| {
                b.iter(|| fit(&interpolator, mesh.positions(), &options));
            });
        }
    }
}

/// Updates alone: elements are vertices times updates, and with so many set-up hardly counts.
fn updates(c: &mut Criterion) {
    const COUNT: u32 = 50;
    let mut group = c.benchmark_group("update");
    group.sample_size(10);
    for mesh in meshes() {
        let count = mesh.positions().len();
        let interpolator = prepare(&mesh);
        group.throughput(Throughput::Elements(count as u64 * u64::from(COUNT)));
        for method in [Method::Plain, Method::ConjugateGradients] {
            let options =
                Options { method, iterations: COUNT, tolerance: None, ..Options::default() };
            group.bench_with_input(BenchmarkId::new(method.name(), count), &mesh, |b, mesh| {
                b.iter(|| fit(&interpolator, mesh.positions(), &options));
            });
        }
    }
}

fn prepare(mesh: &Mesh) -> Interpolator<'_> {
    Interpolator::new(mesh.topology(), &Rules::LOOP).expect("triangles")
}

fn fit(interpolator: &Interpolator, target: &[Vec3], options: &Options) -> Vec<Vec3> {
    let mut ignore = |_, _| ControlFlow::Continue(());
    let fitted = interpolator.fit(black_box(target), options, &mut ignore);
    fitted.expect("ordinary coordinates").0
}

criterion_group!(kernel, topology, refinement, limits, fits, updates);
criterion_main!(kernel);
