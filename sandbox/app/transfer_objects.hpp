// The things on the meadow of the scene `transfer`: their meshes, where they stand and what is baked for them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <alpenglow/prt/bake_volume.hpp>
#include <alpenglow/prt/mesh.hpp>

#include "sandbox/app/transfer_bakes.hpp"
#include "sandbox/scene/transfer_settings.hpp"
#include "sandbox/world/world.hpp"

namespace alpenglow::sandbox {

// One body: its drawn vertices are the first of each mesh that it is baked with.
struct TransferObject {
    std::string name;
    prt::Mesh mesh; // drawn, in the body's frame
    glm::vec3 position_m{0.0F};
    std::optional<BakeJob> diffuse, glossy;
    std::size_t glossy_vertices = 0; // the first ones
    glm::vec3 specular{0.0F};
    double phong_exponent = 0.0;
};

struct TransferObjects {
    glm::vec3 middle_m{0.0F}; // on the ground, in the world
    float radius_m = 0.0F;    // around it lies all that there is
    std::vector<TransferObject> bodies;
    std::size_t mound = 0;  // of the bodies: the ground over which the glider goes
    std::size_t glider = 0; // moves
    std::optional<BakeJob> around_glider, smoke;
    prt::VolumeDensity smoke_density;
    glm::vec3 smoke_position_m{0.0F};
    std::string problem; // the settings' mesh could not be read
};

[[nodiscard]] TransferObjects make_transfer_objects(const World& world, const TransferSettings& settings);

} // namespace alpenglow::sandbox
