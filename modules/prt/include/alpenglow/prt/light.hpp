// Light for an object: into its frame, and sampled at several points where it varies over the object.
#pragma once

#include <alpenglow/core/result.hpp>
#include <alpenglow/prt/transfer_table.hpp>

#include <span>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::prt {

// Radiance coefficients in the scene's frame -> the object's frame. One rotation an object (paper, section 6, step 2).
// in and out: order^2 values, may be the same.
void to_object_frame(int order, const glm::quat& scene_from_object, std::span<const glm::vec3> in,
                     std::span<glm::vec3> out);

// The rotation in an object's transform. Uniform scale does not change transfer and is taken out; a mirrored, sheared
// or non-uniformly scaled transform would (angles change), and is an Error. `tolerance` is relative.
[[nodiscard]] Result<glm::quat> rotation_of(const glm::mat3& scene_from_object, float tolerance = 1e-3F);

// Points near an object where to sample the light, spread over it by clustering (the paper's section 6.1), and what
// each vertex takes of each. Deterministic.
struct LightSamples {
    std::vector<glm::vec3> points_m; // object's frame
    std::vector<float> weights;      // [vertex][point], each vertex's sum is 1
    std::vector<float> mean_weights; // of each point
};
[[nodiscard]] LightSamples light_samples(std::span<const glm::vec3> positions_m, std::size_t count);

// Exit radiance under light that varies: out[v] = sum_p weights[v][p] M_v . lights[p]. lights is [point][order^2], in
// the object's frame. Costs one evaluation a sample; `scratch` is resized to the table's count.
void evaluate_varying(const TransferTable& table, const LightSamples& samples, int order,
                      std::span<const glm::vec3> lights, std::span<glm::vec3> out, std::vector<glm::vec3>& scratch);

// |dL_l| of each band: the 2-norm over the band's coefficients, the largest of the three channels. out: order values.
void band_change(int order, std::span<const glm::vec3> a, std::span<const glm::vec3> b, std::span<float> out) noexcept;

// A bound on how far any result of `table` moves when light `made_from` (in the object's frame's rotation `from`)
// becomes `now` (rotation `to`): sum_l band_norm[l] (|dL_l| + |D_l(angle)| |L_l|), where turning a band by a small
// angle moves it by at most min(2, l angle) of its norm. No rotation of coefficients is needed. Unit of the light.
[[nodiscard]] float change_bound(const TransferInfo& info, int order, std::span<const glm::vec3> made_from,
                                 const glm::quat& from, std::span<const glm::vec3> now, const glm::quat& to) noexcept;

} // namespace alpenglow::prt
