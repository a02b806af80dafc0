// OpenVDB files and grids. The only header of the module that knows of OpenVDB, and only by an opaque handle.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <alpenglow/clouds/grid.hpp>
#include <alpenglow/core/result.hpp>

namespace alpenglow::clouds {

// A shared openvdb::FloatGrid. Cast `grid.get()` to `const openvdb::FloatGrid*` to work on it with OpenVDB itself.
struct VdbGrid {
    std::shared_ptr<const void> grid;

    [[nodiscard]] std::string name() const;
    [[nodiscard]] std::size_t memory_bytes() const;  // of its tree, as OpenVDB counts it
    [[nodiscard]] std::size_t active_voxels() const; // tiles counted in full
};

struct VdbGridInfo {
    std::string name;
    std::string value_type; // "float", "vec3s", ...
    glm::ivec3 min{0};      // of the active voxels' bounding box, where the file's metadata has it
    glm::ivec3 max{0};
};

// What a file holds, without reading its voxels.
[[nodiscard]] Result<std::vector<VdbGridInfo>> list_vdb(const std::string& path);

// Reads one float grid: the named one, else the one called "density", else the first float grid.
[[nodiscard]] Result<VdbGrid> load_vdb(const std::string& path, const std::string& grid_name = {});

[[nodiscard]] Status save_vdb(const std::string& path, std::span<const VdbGrid> grids);

// How much a grid may take once its active tiles are spread out.
struct VdbLimits {
    std::size_t max_bytes = std::size_t(2) << 30;
};

// Checks and copies: density finite and >= 0, background 0, a transform of rotation and scale, extent and memory within
// the limits. `where` names the grid in errors.
[[nodiscard]] Result<SparseGrid> sparse_from_vdb(const VdbGrid& grid, const std::string& where,
                                                 const VdbLimits& limits = {});

[[nodiscard]] VdbGrid vdb_from_sparse(const SparseGrid& grid, const std::string& name);

// The peer and the oracle: OpenVDB's accessor with its BoxSampler, one point after the other. Index coordinates.
void sample_vdb(const VdbGrid& grid, std::span<const glm::vec3> index, std::span<float> density);

// The peer for whole frames: the spans of the ray origin + t * direction (index coordinates) that OpenVDB's
// VolumeRayIntersector calls active, each marched with `step` (in t); calls add(user, t, density) front to back until
// it returns false. Rays are given and marched in order.
void march_vdb(const VdbGrid& grid, std::span<const glm::vec3> origins, std::span<const glm::vec3> directions,
               float step, bool (*add)(void* user, std::size_t ray, float t, float density), void* user);

} // namespace alpenglow::clouds
