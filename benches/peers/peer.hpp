// What all peers share: the command line, an OBJ reader, the clock, the peak of memory, and the one
// line of JSON that each prints.
//
//     PEER MESH.obj SCHEME LEVELS REPEATS [HOW]
//
// A peer is a function that goes from flat arrays to flat arrays through a library, and says when it
// has built the library's own structure, refined it, and copied the result out.

#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace peer {

// Polygons as flat arrays: three numbers per point, and the corners of face after face.
struct Arrays {
    std::vector<double> points;
    std::vector<int> sizes;
    std::vector<int> corners;

    int vertex_count() const { return static_cast<int>(points.size() / 3); }
    int face_count() const { return static_cast<int>(sizes.size()); }
};

struct Task {
    Arrays mesh;
    std::string scheme;
    int levels;
    int repeats;
    std::string how;
};

[[noreturn]] inline void fail(std::string const& why) {
    std::fprintf(stderr, "%s\n", why.c_str());
    std::exit(2);
}

// Reads `v` and `f` lines; all else in the file is left aside.
inline Arrays read_obj(char const* path) {
    std::ifstream file(path);
    if (!file) fail(std::string("cannot read ") + path);
    Arrays mesh;
    std::string line;
    while (std::getline(file, line)) {
        char* rest = line.data() + 1;
        if (line.rfind("v ", 0) == 0) {
            for (int i = 0; i < 3; i++) mesh.points.push_back(std::strtod(rest, &rest));
        } else if (line.rfind("f ", 0) == 0) {
            int size = 0;
            std::istringstream words(rest);
            for (std::string word; words >> word; size++) {
                mesh.corners.push_back(std::atoi(word.c_str()) - 1);
            }
            mesh.sizes.push_back(size);
        }
    }
    return mesh;
}

inline Task task(int argc, char** argv) {
    if (argc < 5) fail("usage: PEER MESH.obj SCHEME LEVELS REPEATS [HOW]");
    return {read_obj(argv[1]), argv[2], std::atoi(argv[3]), std::max(1, std::atoi(argv[4])),
            argc > 5 ? argv[5] : ""};
}

// Bytes that /proc/self/status names, or 0 where there is none.
inline long status_bytes(char const* name) {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        if (line.rfind(name, 0) == 0) return 1024 * std::atol(line.c_str() + std::strlen(name) + 1);
    }
    return 0;
}

// Starts the peak of resident memory anew.
inline void reset_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

inline double cpu_seconds() {
    timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Seconds of the parts of one run.
class Laps {
  public:
    Laps() : cpu_start_(cpu_seconds()), last_(Clock::now()) {}

    // Ends a part.
    void lap() {
        auto now = Clock::now();
        parts_.push_back(std::chrono::duration<double>(now - last_).count());
        cpu_ = cpu_seconds() - cpu_start_;
        last_ = now;
    }

    std::vector<double> const& parts() const { return parts_; }
    double cpu() const { return cpu_; }

  private:
    using Clock = std::chrono::steady_clock;
    double cpu_start_;
    double cpu_ = 0;
    Clock::time_point last_;
    std::vector<double> parts_;
};

// The result of a run as flat arrays. Left uninitialised until written, as nobody needs the zeros.
template <class Real> struct Result {
    std::size_t vertex_count = 0, face_count = 0, corner_count = 0;
    std::unique_ptr<Real[]> points;
    std::unique_ptr<int[]> corners;

    Result(std::size_t vertices, std::size_t faces, std::size_t corner_count)
        : vertex_count(vertices), face_count(faces), corner_count(corner_count),
          points(new Real[3 * vertices]), corners(new int[corner_count]) {}
};

// What tells two results apart without all their numbers: counts, mean, mean square, box.
struct Summary {
    std::size_t vertices, faces;
    std::array<double, 3> mean{}, min, max;
    double square = 0;
};

template <class Real> Summary summary(Result<Real> const& result) {
    Summary s{result.vertex_count, result.face_count, {}, {}, {}};
    s.min.fill(std::numeric_limits<double>::infinity());
    s.max.fill(-std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < 3 * result.vertex_count; i++) {
        double x = static_cast<double>(result.points[i]);
        s.mean[i % 3] += x / static_cast<double>(result.vertex_count);
        s.min[i % 3] = std::min(s.min[i % 3], x);
        s.max[i % 3] = std::max(s.max[i % 3], x);
        s.square += x * x / static_cast<double>(result.vertex_count);
    }
    return s;
}

inline void print_list(char const* name, double const* begin, std::size_t count) {
    std::printf("\"%s\":[", name);
    for (std::size_t i = 0; i < count; i++) std::printf(i ? ",%.17g" : "%.17g", begin[i]);
    std::printf("],");
}

// Runs `once(task, laps)` as often as asked for and prints the line.
template <class Once> int run(Task const& task, std::string const& library, Once once) {
    std::vector<std::vector<double>> samples;
    std::vector<double> cpu;
    Summary s{};
    long before = status_bytes("VmRSS:"), peak = 0;
    reset_peak();
    for (int i = 0; i < task.repeats; i++) {
        Laps laps;
        auto result = once(task, laps);
        samples.push_back(laps.parts());
        cpu.push_back(laps.cpu());
        if (i == 0) {
            peak = status_bytes("VmHWM:") - before;
            s = summary(result);
        }
    }
    std::printf("{\"library\":\"%s\",\"vertices\":%zu,\"faces\":%zu,", library.c_str(), s.vertices,
                s.faces);
    print_list("mean", s.mean.data(), 3);
    print_list("min", s.min.data(), 3);
    print_list("max", s.max.data(), 3);
    print_list("square", &s.square, 1);
    print_list("cpu", cpu.data(), cpu.size());
    std::printf("\"samples\":[");
    for (std::size_t i = 0; i < samples.size(); i++) {
        std::printf(i ? ",[" : "[");
        for (std::size_t k = 0; k < samples[i].size(); k++) {
            std::printf(k ? ",%.9g" : "%.9g", samples[i][k]);
        }
        std::printf("]");
    }
    std::printf("],\"bytes\":%ld}\n", peak);
    return 0;
}

} // namespace peer
