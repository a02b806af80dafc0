// The things that stand in the landscape: low-polygon meshes made by rule, flat-shaded.
#pragma once

#include "render_data.hpp"

#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::sandbox {

enum class ObjectKind : std::uint32_t { hut, chapel, barn, spruce, larch, boulder, linden, fence, grove };
inline constexpr std::uint32_t object_kinds = 9;

inline constexpr float fence_m = 12.0F; // length of a piece, along X
inline constexpr float grove_m = 24.0F; // side of the square that a grove's trees fill

// Object space: metres, foot of the object at the origin, +Z up, the front towards -Y. Foundations reach below z = 0,
// so that nothing floats on a slope.
struct ObjectMesh {
    MeshData mesh;                              // sky visibility 1, horizon 0: instances carry the terrain's
    std::vector<std::vector<glm::vec3>> solids; // convex hulls that together throw its shadow; none: no shadow
    float radius_m = 0.0F;                      // on the ground
    float height_m = 0.0F;
};

[[nodiscard]] ObjectMesh make_object_mesh(ObjectKind kind);

} // namespace alpenglow::sandbox
