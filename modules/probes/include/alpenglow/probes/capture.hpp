// Probes from pictures of the scene.
#pragma once

#include <alpenglow/components/light_probe.hpp>

#include <cstdint>
#include <functional>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::probes {

inline constexpr int capture_size = 16;         // texels along a face's edge, as projected
inline constexpr int capture_supersampling = 2; // samples along a texel's edge, as rendered

// Renders one face of the cube map that is seen from a point: linear Rec.709 radiance in cd/m^2, without the discs of
// sun and moon (probes add them as punctual lights). `texels` has edge * edge values, edge = capture_size *
// capture_supersampling, row by row. Faces are +X -X +Y -Y +Z -Z; texel_direction() says which way a texel looks. Runs
// on the CPU or the GPU, as the game likes, and returns once the texels are there.
using RenderFace = std::function<void(const glm::vec3& point_m, int face, int edge, std::span<glm::vec3> texels)>;

// How a game captures. `budget`: probes a frame.
struct Capture {
    RenderFace render;
    std::uint32_t budget = 4;
};

// Unit vector through the centre of texel (column, row) of a face with `edge` texels along its edge. OpenGL's and
// Vulkan's cube map layout.
[[nodiscard]] glm::vec3 texel_direction(int face, int column, int row, int edge) noexcept;

// Renders six faces and projects them: out holds order * order coefficients of radiance, cd/m^2. Texels count by their
// exact solid angles. All coefficients are NaN where a texel is not finite: assemble() keeps such a probe out.
void capture_probe(const glm::vec3& point_m, int order, const RenderFace& render, std::span<glm::vec3> out);

} // namespace alpenglow::probes
