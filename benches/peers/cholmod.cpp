// CHOLMOD: control points of a closed triangle mesh whose Loop limit points are the given vertices.
//
// The limit operator is B = D S with S symmetric: S has a 1 on every edge and n β / (1 − β) on the
// diagonal, D is (1 − β) / n, β = 3 / (8 − 8 (3/8 + cos(2π/n) / 4)²). Build: S from arrays, its
// order and factor. Refine: three right-hand sides solved. HOW is `simplicial` to factorise entry by
// entry, `supernodal` in blocks, `metis` in blocks and ordered by nested dissection, or nothing for
// CHOLMOD to choose.

#include "peer.hpp"

#include <cholmod.h>

// n β / (1 − β) of a vertex with n neighbours.
static double diagonal(int n) {
    double c = 0.375 + 0.25 * std::cos(2 * M_PI / n);
    double beta = 3 / (8 - 8 * c * c);
    return n * beta / (1 - beta);
}

// The lower triangle of S. Each edge of a closed mesh is a corner's edge upwards exactly once.
static cholmod_sparse* operator_of(peer::Arrays const& mesh, std::vector<double> const& own,
                                   cholmod_common& common) {
    int n = mesh.vertex_count();
    std::vector<int> count(n, 1);
    auto for_edges = [&](auto each) {
        for (std::size_t c = 0; c < mesh.corners.size(); c++) {
            int a = mesh.corners[c], b = mesh.corners[c % 3 == 2 ? c - 2 : c + 1];
            if (a < b) each(a, b);
        }
    };
    for_edges([&](int a, int) { count[a]++; });
    std::size_t entries = n + mesh.corners.size() / 2;
    auto* s = cholmod_allocate_sparse(n, n, entries, false, true, -1, CHOLMOD_REAL, &common);
    auto *start = static_cast<int*>(s->p), *row = static_cast<int*>(s->i);
    auto* value = static_cast<double*>(s->x);
    start[0] = 0;
    for (int v = 0; v < n; v++) start[v + 1] = start[v] + count[v];
    std::vector<int> next(start, start + n);
    for (int v = 0; v < n; v++) {
        row[next[v]] = v;
        value[next[v]++] = own[v];
    }
    for_edges([&](int a, int b) {
        row[next[a]] = b;
        value[next[a]++] = 1;
    });
    return s;
}

static peer::Result<double> once(peer::Task const& task, peer::Laps& laps) {
    auto const& mesh = task.mesh;
    std::size_t n = mesh.vertex_count();
    cholmod_common common;
    cholmod_start(&common);
    if (task.how == "simplicial") common.supernodal = CHOLMOD_SIMPLICIAL;
    if (task.how == "supernodal" || task.how == "metis") common.supernodal = CHOLMOD_SUPERNODAL;
    if (task.how == "metis") {
        common.nmethods = 1;
        common.method[0].ordering = CHOLMOD_METIS;
    }
    std::vector<int> valence(n, 0);
    for (int v : mesh.corners) valence[v]++;
    std::vector<double> own(n);
    for (std::size_t v = 0; v < n; v++) own[v] = diagonal(valence[v]);
    auto* s = operator_of(mesh, own, common);
    auto* factor = cholmod_analyze(s, &common);
    if (!cholmod_factorize(s, factor, &common) || common.status != CHOLMOD_OK) {
        peer::fail("CHOLMOD does not factorise it");
    }
    laps.lap();
    auto* right = cholmod_allocate_dense(n, 3, n, CHOLMOD_REAL, &common);
    auto* to = static_cast<double*>(right->x);
    for (std::size_t v = 0; v < n; v++) {
        // D⁻¹ = n / (1 − β), which is the valence and the diagonal together.
        for (int k = 0; k < 3; k++) to[k * n + v] = (valence[v] + own[v]) * mesh.points[3 * v + k];
    }
    auto* x = cholmod_solve(CHOLMOD_A, factor, right, &common);
    laps.lap();
    peer::Result<double> result(n, mesh.face_count(), mesh.corners.size());
    auto const* from = static_cast<double*>(x->x);
    for (std::size_t i = 0; i < 3 * n; i++) result.points[i] = from[i % 3 * n + i / 3];
    laps.lap();
    cholmod_free_dense(&x, &common);
    cholmod_free_dense(&right, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&s, &common);
    cholmod_finish(&common);
    return result;
}

int main(int argc, char** argv) {
    auto task = peer::task(argc, argv);
    auto is_triangle = [](int size) { return size == 3; };
    if (!std::all_of(task.mesh.sizes.begin(), task.mesh.sizes.end(), is_triangle)) {
        peer::fail("triangles only");
    }
    auto part = [](int n) { return std::to_string(n); };
    return peer::run(task,
                     "CHOLMOD " + part(CHOLMOD_MAIN_VERSION) + "." + part(CHOLMOD_SUB_VERSION) +
                         "." + part(CHOLMOD_SUBSUB_VERSION),
                     once);
}
