// OpenSubdiv: uniform refinement in the two ways it offers.
//
// HOW is `primvar`, level by level and the faster one when values are refined once; `stencils`, a
// table that is built once and then takes any positions; `limit`, as `primvar` and then the limit
// points and normals of the refined vertices; or `places`, the same points and normals by a table of
// limit stencils, each vertex once, which knows no finer faces. With `64` behind it the numbers are
// doubles; single precision is what the library itself uses.

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

// Normals from tangents, in place of the first of them.
template <class Real> void normals(Point<Real>* u, Point<Real> const* v, std::size_t count) {
    for (std::size_t i = 0; i < count; i++) {
        auto& a = u[i].at;
        auto const& b = v[i].at;
        Real n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                     a[0] * b[1] - a[1] * b[0]};
        Real length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int k = 0; k < 3; k++) a[k] = n[k] / length;
    }
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
        normals(to_u, to_v, count);
        coarse = std::move(at);
    }
    laps.lap();
    auto result = faces<Real>(*topology, task.levels);
    std::memcpy(result.points.get(), coarse.get(), 3 * sizeof(Real) * result.vertex_count);
    laps.lap();
    return result;
}

// The places of the refined vertices on the faces of the mesh, each on the first face that has it.
template <class Real> class Places {
  public:
    Places(Far::TopologyLevel const& mesh, bool triangles, int side) : side_(side) {
        for (int f = 0; f < mesh.GetNumFaces(); f++) {
            auto vertices = mesh.GetFaceVertices(f), edges = mesh.GetFaceEdges(f);
            int corners = vertices.size();
            if (corners != (triangles ? 3 : 4)) peer::fail("faces of one kind only");
            bool has_vertex[4], has_edge[4];
            for (int i = 0; i < corners; i++) {
                has_vertex[i] = mesh.GetVertexFaces(vertices[i])[0] == f;
                has_edge[i] = mesh.GetEdgeFaces(edges[i])[0] == f;
            }
            std::size_t before = s_.size();
            for (int j = 0; j <= side; j++) {
                for (int i = 0; i <= (triangles ? side - j : side); i++) {
                    // The edges that it lies on, in their order around the face.
                    bool on[4] = {j == 0, (triangles ? i + j : i) == side,
                                  triangles ? i == 0 : j == side, !triangles && i == 0};
                    if (is_own(on, corners, has_vertex, has_edge)) add(i, j);
                }
            }
            counts_.push_back(static_cast<int>(s_.size() - before));
        }
    }

    std::size_t count() const { return s_.size(); }

    using Factory = Far::LimitStencilTableFactoryReal<Real>;
    typename Factory::LocationArrayVec arrays() const {
        typename Factory::LocationArrayVec arrays(counts_.size());
        std::size_t at = 0;
        for (std::size_t f = 0; f < arrays.size(); f++) {
            arrays[f].ptexIdx = static_cast<int>(f);
            arrays[f].numLocations = counts_[f];
            arrays[f].s = s_.data() + at;
            arrays[f].t = t_.data() + at;
            at += counts_[f];
        }
        return arrays;
    }

  private:
    int side_;
    std::vector<Real> s_, t_;
    std::vector<int> counts_;

    static bool is_own(bool const* on, int corners, bool const* vertex, bool const* edge) {
        for (int i = 0; i < corners; i++) {
            if (on[i] && on[(i + 1) % corners]) return vertex[(i + 1) % corners];
        }
        for (int i = 0; i < corners; i++) {
            if (on[i]) return edge[i];
        }
        return true;
    }

    void add(int i, int j) {
        s_.push_back(static_cast<Real>(i) / side_);
        t_.push_back(static_cast<Real>(j) / side_);
    }
};

template <class Real> peer::Result<Real> at_places(peer::Task const& task, peer::Laps& laps) {
    auto topology = refiner(task);
    topology->RefineAdaptive(Far::TopologyRefiner::AdaptiveOptions(task.levels));
    bool triangles = task.scheme == "loop";
    Places<Real> places(topology->GetLevel(0), triangles, 1 << task.levels);
    using Factory = Far::LimitStencilTableFactoryReal<Real>;
    std::unique_ptr<Far::LimitStencilTableReal<Real> const> table(
        Factory::Create(*topology, places.arrays()));
    auto control = control_points<Real>(task);
    laps.lap();
    std::size_t count = places.count();
    std::unique_ptr<Point<Real>[]> at(new Point<Real>[count]), u(new Point<Real>[count]),
        v(new Point<Real>[count]);
    auto *to = at.get(), *to_u = u.get(), *to_v = v.get();
    table->UpdateValues(control.get(), to);
    table->UpdateDerivs(control.get(), to_u, to_v);
    normals(to_u, to_v, count);
    laps.lap();
    std::size_t parts = std::size_t(1) << 2 * task.levels;
    peer::Result<Real> result(count, parts * task.mesh.face_count(), 0);
    std::memcpy(result.points.get(), to, 3 * sizeof(Real) * count);
    laps.lap();
    return result;
}

template <class Real> int run(peer::Task const& task) {
    auto is = [&](char const* how) { return task.how.rfind(how, 0) == 0; };
    auto once = is("stencils") ? with_stencils<Real>
                : is("places") ? at_places<Real>
                               : level_by_level<Real>;
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
