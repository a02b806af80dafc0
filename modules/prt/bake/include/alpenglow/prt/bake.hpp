// Bakes diffuse transfer vectors: Sloan, Kautz and Snyder (2002), section 5, with Embree's rays.
#pragma once

#include <alpenglow/prt/transfer_table.hpp>
#include <alpenglow/prt/validate.hpp>

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace alpenglow::prt {

enum class Transport {
    unshadowed,     // T_DU: the cosine alone
    shadowed,       // T_DS, eq. 10
    interreflected, // T_DI: bounces off the object itself
};

// How a point's hemisphere is sampled; all with density cos/pi. The first three exist for comparison.
enum class Sampling {
    random,
    stratified, // jittered squares
    fibonacci,  // one golden spiral, turned about each point's normal
    adaptive,   // a coarse grid, refined where visibility changes
};

struct Progress {
    double fraction = 0.0;  // of the whole bake
    double remaining_s = 0; // wall clock, estimated
    const char* stage = ""; // "rays", "bounces"
};
// Called now and then, never by two threads at once. Return false to cancel: the bake then ends with an Error soon.
using ProgressCallback = std::function<bool(const Progress&)>;

struct BakeSettings {
    Transport transport = Transport::shadowed;
    Sampling sampling = Sampling::adaptive;
    int order = 5;                 // bands, 1 .. 6
    std::size_t rays = 4096;       // a point: all of them for the plain samplings, the finest grid for adaptive
    double max_error = 5e-3;       // adaptive: stop where the estimated relative error of a point is below
    std::size_t gather_rays = 256; // a point, for bounces
    int max_bounces = 32;
    double stop_energy = 1e-4;   // bounces end when one adds less than this part of the direct light
    bool colour = false;         // RGB transfer: albedo bleeds
    float default_albedo = 0.5F; // of meshes without albedo
    std::uint64_t seed = 1;
    unsigned threads = 0;                             // 0: parallel_threads(); the result is the same for any number
    std::size_t memory_bytes = std::size_t{1} << 30U; // for the hits that bounces use; past it they are traced again
    ProgressCallback progress;
    bool measure_tracer = false; // fill BakeReport::tracing_cpu_s: reading the clock costs as much as a few rays
};

// What came of it. Errors of transfer vectors are relative: 2-norm of the difference over the 2-norm of an unoccluded
// point's vector, RMS over the points.
struct BakeReport {
    MeshReport mesh;
    std::size_t points = 0;
    std::size_t dark_points = 0;   // not lit at all
    std::size_t inside_points = 0; // most of what they see are backs of triangles
    std::uint64_t shadow_rays = 0;
    std::uint64_t gather_rays = 0;
    double estimated_rms = 0.0;        // from the spread at visibility edges
    std::vector<double> bounce_energy; // each bounce's mean response to constant light over the direct one
    // Mean response of lit points to constant light if every albedo were 1, which is 1 if no light gets lost, and the
    // response farthest from 1. NaN where nothing bounces or the hits were not kept.
    double furnace_mean = std::numeric_limits<double>::quiet_NaN();
    double furnace_worst = std::numeric_limits<double>::quiet_NaN();
    bool hits_kept = true;      // false: memory_bytes was too small, bounces traced again
    double rays_cpu_s = 0.0;    // making, shooting and summing up rays
    double tracing_cpu_s = 0.0; // of that, shadow rays within the ray tracer, if measured
    double bounces_cpu_s = 0.0;
    double wall_s = 0.0;

    [[nodiscard]] std::string text() const; // for people, one fact a line
};

struct Bake {
    TransferField field;
    BakeReport report;
};

// One vector a vertex. Normals are computed where the mesh has none.
[[nodiscard]] Result<Bake> bake(const Mesh& mesh, const BakeSettings& settings);

// Where to bake, when not at the vertices: texels of a heightfield or lightmap. A zero normal marks a texel that nobody
// uses. Bounces come from the mesh's own vertices.
struct BakePoints {
    std::vector<glm::vec3> positions_m;
    std::vector<glm::vec3> normals;
};
[[nodiscard]] Result<Bake> bake_points(const Mesh& mesh, const BakePoints& points, const BakeSettings& settings);

// A part of a bake: the rays of vertices [first, first + count). Parts are made anywhere, in any order; `finish` joins
// them, does the bounces (which shoot no rays) and gives what `bake` would give, bit for bit.
struct GatherHit {
    std::uint32_t triangle = 0;
    std::uint16_t u = 0; // barycentrics, 65535 = 1
    std::uint16_t v = 0;
};
struct BakePart {
    std::uint64_t mesh_hash = 0;
    std::uint64_t settings_hash = 0;
    std::size_t first = 0;
    std::size_t count = 0;
    std::vector<float> direct;             // [point][coefficient]
    std::vector<float> visibility;         // [point] cosine-weighted, 0 .. 1
    std::vector<float> variance;           // [point] of the direct vector, estimated
    std::vector<std::uint32_t> hit_counts; // [point]
    std::vector<GatherHit> hits;           // of the points, one after the other
    std::uint64_t shadow_rays = 0;
    std::uint64_t gather_rays = 0;
    std::size_t inside_points = 0;
    double cpu_s = 0.0;
    double tracing_cpu_s = 0.0;
};
[[nodiscard]] Result<BakePart> bake_part(const Mesh& mesh, const BakeSettings& settings, std::size_t first,
                                         std::size_t count);
[[nodiscard]] Result<Bake> finish(const Mesh& mesh, const BakeSettings& settings, std::vector<BakePart> parts);

// Vertices [first, last) of shard k (1 .. n).
struct ShardRange {
    std::size_t first = 0;
    std::size_t last = 0;
};
[[nodiscard]] ShardRange shard_range(std::size_t count, std::size_t shard, std::size_t shards) noexcept;

// T_DU in closed form: the clamped cosine about `normal` over pi.
void unshadowed(int order, const glm::vec3& normal, std::span<float> out) noexcept;

} // namespace alpenglow::prt
