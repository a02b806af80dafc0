// Whether a result still holds, and making it anew: the mathematics behind update_transfer.
#pragma once

#include <alpenglow/components/transfer.hpp>
#include <alpenglow/prt/light.hpp>

#include <cstdint>

namespace alpenglow::prt {

// The bound of change_bound, relative to the response of the table's most open point to the light's mean radiance:
// |L_0| band_norm[0]. Infinite where the new light has no mean.
[[nodiscard]] float relative_change(const TransferInfo& info, int order, std::size_t samples,
                                    std::span<const glm::vec3> made_from, const glm::quat& from,
                                    std::span<const glm::vec3> now, const glm::quat& to) noexcept;

// Error of `result` over source.max_error: 0 where there is nothing to do (not visible, no table, no light) or nothing
// has changed, infinity where there is no result of this table yet. Stores the error in result->error_bound.
[[nodiscard]] float urgency(const TransferSource& source, const ObjectLight& light, TransferResult* result) noexcept;

// Points that recompute would evaluate: the cost, about.
[[nodiscard]] std::uint64_t cost_points(const TransferSource& source) noexcept;

// Makes `result` from source and light. source.table and light.bands must be set.
void recompute(const TransferSource& source, const LightSamples* samples, const ObjectLight& light,
               TransferResult& result);

} // namespace alpenglow::prt
