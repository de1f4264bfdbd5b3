// OpenSubdiv: uniform refinement in the two ways it offers.
//
// HOW is `primvar`, level by level and the faster one when values are refined once; `stencils`, a
// table that is built once and then takes any positions; or `limit`, as `primvar` and then the limit
// points and normals of the refined vertices. With `64` behind it the numbers are doubles; single
// precision is what the library itself uses.

#include "peer.hpp"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTable.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>
#include <opensubdiv/version.h>

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

template <class Real> struct Point {
    Real at[3];

    void Clear(void* = nullptr) { at[0] = at[1] = at[2] = 0; }
    void AddWithWeight(Point const& p, Real weight) {
        for (int i = 0; i < 3; i++) at[i] += weight * p.at[i];
    }
};

static std::unique_ptr<Far::TopologyRefiner> refiner(peer::Task const& task) {
    Far::TopologyDescriptor descriptor;
    descriptor.numVertices = task.mesh.vertex_count();
    descriptor.numFaces = task.mesh.face_count();
    descriptor.numVertsPerFace = task.mesh.sizes.data();
    descriptor.vertIndicesPerFace = task.mesh.corners.data();
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
    auto type = task.scheme == "loop" ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK;
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    std::unique_ptr<Far::TopologyRefiner> made(
        Factory::Create(descriptor, Factory::Options(type, options)));
    if (!made) peer::fail("OpenSubdiv does not take the mesh");
    return made;
}

template <class Real> std::unique_ptr<Point<Real>[]> control_points(peer::Task const& task) {
    std::size_t count = task.mesh.vertex_count();
    std::unique_ptr<Point<Real>[]> points(new Point<Real>[count]);
    for (std::size_t i = 0; i < 3 * count; i++) {
        points[i / 3].at[i % 3] = static_cast<Real>(task.mesh.points[i]);
    }
    return points;
}

// A result with the faces of the last level, and room for its points.
template <class Real> peer::Result<Real> faces(Far::TopologyRefiner const& refiner, int levels) {
    auto level = refiner.GetLevel(levels);
    peer::Result<Real> result(level.GetNumVertices(), level.GetNumFaces(),
                              level.GetNumFaceVertices());
    int* corner = result.corners.get();
    for (int f = 0; f < level.GetNumFaces(); f++) {
        auto vertices = level.GetFaceVertices(f);
        corner = std::copy(vertices.begin(), vertices.end(), corner);
    }
    return result;
}

template <class Real>
peer::Result<Real> with_stencils(peer::Task const& task, peer::Laps& laps) {
    auto topology = refiner(task);
    topology->RefineUniform(Far::TopologyRefiner::UniformOptions(task.levels));
    using Factory = Far::StencilTableFactoryReal<Real>;
    typename Factory::Options options;
    options.generateIntermediateLevels = false;
    options.generateOffsets = false;
    std::unique_ptr<Far::StencilTableReal<Real> const> table(Factory::Create(*topology, options));
    auto control = control_points<Real>(task);
    laps.lap();
    std::unique_ptr<Point<Real>[]> fine(new Point<Real>[table->GetNumStencils()]);
    auto* to = fine.get();
    table->UpdateValues(control.get(), to);
    laps.lap();
    auto result = faces<Real>(*topology, task.levels);
    std::memcpy(result.points.get(), fine.get(), 3 * sizeof(Real) * result.vertex_count);
    laps.lap();
    return result;
}

template <class Real> peer::Result<Real> level_by_level(peer::Task const& task, peer::Laps& laps) {
    bool limit = task.how.rfind("limit", 0) == 0;
    auto topology = refiner(task);
    Far::TopologyRefiner::UniformOptions uniform(task.levels);
    // The limit needs the neighbours of the last level too, which are left out otherwise.
    uniform.fullTopologyInLastLevel = limit;
    topology->RefineUniform(uniform);
    auto coarse = control_points<Real>(task);
    laps.lap();
    Far::PrimvarRefinerReal<Real> primvar(*topology);
    for (int level = 1; level <= task.levels; level++) {
        std::size_t count = topology->GetLevel(level).GetNumVertices();
        std::unique_ptr<Point<Real>[]> fine(new Point<Real>[count]);
        auto* to = fine.get();
        primvar.Interpolate(level, coarse.get(), to);
        coarse = std::move(fine);
    }
    if (limit) {
        std::size_t count = topology->GetLevel(task.levels).GetNumVertices();
        std::unique_ptr<Point<Real>[]> at(new Point<Real>[count]), u(new Point<Real>[count]),
            v(new Point<Real>[count]);
        auto *to = at.get(), *to_u = u.get(), *to_v = v.get();
        primvar.Limit(coarse.get(), to, to_u, to_v);
        for (std::size_t i = 0; i < count; i++) {
            auto &a = u[i].at, &b = v[i].at;
            Real n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                         a[0] * b[1] - a[1] * b[0]};
            Real length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            for (int k = 0; k < 3; k++) a[k] = n[k] / length;
        }
        coarse = std::move(at);
    }
    laps.lap();
    auto result = faces<Real>(*topology, task.levels);
    std::memcpy(result.points.get(), coarse.get(), 3 * sizeof(Real) * result.vertex_count);
    laps.lap();
    return result;
}

template <class Real> int run(peer::Task const& task) {
    auto once = task.how.rfind("stencils", 0) == 0 ? with_stencils<Real> : level_by_level<Real>;
    int version = OPENSUBDIV_VERSION_NUMBER;
    auto part = [](int n) { return std::to_string(n); };
    return peer::run(task,
                     "OpenSubdiv " + part(version / 10000) + "." + part(version / 100 % 100) + "." +
                         part(version % 100),
                     once);
}

int main(int argc, char** argv) {
    auto task = peer::task(argc, argv);
    if (task.scheme != "loop" && task.scheme != "catmull-clark") peer::fail("no such scheme");
    bool doubles = task.how.find("64") != std::string::npos;
    return doubles ? run<double>(task) : run<float>(task);
}
