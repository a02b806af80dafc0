// Precomputed radiance transfer: what a designer attaches to an object, and what update_transfer writes.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

namespace alpenglow {

namespace prt {
struct TransferTable; // alpenglow/prt/transfer_table.hpp
struct LightSamples;  // alpenglow/prt/light.hpp
} // namespace prt

// Input, written by whoever lights the object (probes, the sky, the game): radiance coefficients in the scene's frame,
// cd/m^2, deringed where they must not turn negative behind occluders. [sample][bands^2]: one sample at the object's
// centre, or one at each point of the object's LightSamples.
struct ObjectLight {
    int bands = 0; // 1 .. 6
    std::vector<glm::vec3> coefficients;
    std::uint32_t revision = 0; // raise it with every change: an unchanged one is not looked at
};

// What the three kinds of transfer share.
struct TransferSource {
    std::shared_ptr<const prt::TransferTable> table;     // none: nothing to do
    glm::quat scene_from_object{1.0F, 0.0F, 0.0F, 0.0F}; // rotation only: prt::rotation_of takes it from a transform
    float max_error = 0.01F; // change that may go unnoticed, relative to the most open point under the light's mean
    bool visible = true;
    bool on_gpu = false; // shaders evaluate the table: only the light in the object's frame is written
};

// Input: an object that shades itself. Vector tables (diffuse) or matrix tables (glossy).
struct TransferMesh : TransferSource {
    std::shared_ptr<const prt::LightSamples> samples; // where the light varies over the object; vector tables only
};
// Input: smoke or a small cloud that shades itself, one value a voxel.
struct TransferVolume : TransferSource {};
// Input: what an object does to the light around it, one sphere of light a grid point. A neighbourhood moves and turns
// with its object; receivers sample it (prt::sample_neighbourhood).
struct NeighbourhoodTransfer : TransferSource {};

// Output of update_transfer, on entities with one of the three.
struct TransferResult {
    // Vector tables: exit radiance of albedo 1 by point, cd/m^2. Matrix tables: coefficients of transferred radiance,
    // [coefficient][point], for lobe and view to finish. Empty with on_gpu.
    std::vector<glm::vec3> radiance;
    std::vector<glm::vec3> object_light; // the light in the object's frame, [sample][bands^2]: for shaders
    int bands = 0;
    float error_bound = 0.0F; // as of the last look, relative like max_error
    // What this was made from.
    std::vector<glm::vec3> made_from_light;
    glm::quat made_from_rotation{1.0F, 0.0F, 0.0F, 0.0F};
    std::shared_ptr<const prt::TransferTable> made_from_table;
    std::uint32_t light_revision = 0;
    std::uint32_t revision = 0; // counts recomputations
};

// Optional, in the registry's context: how much update_transfer may do ahead of need in a frame. Objects past half
// of their max_error are then refreshed, the most urgent first, so that many objects under one moving sun do not
// fall due in the same frame. Objects past max_error are refreshed in any case.
struct TransferBudget {
    std::uint64_t points_per_frame = 20000;
};

} // namespace alpenglow
