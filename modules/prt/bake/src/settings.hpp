// What every baker asks of its settings.
#pragma once

#include <alpenglow/prt/bake.hpp>

#include <cstdint>

namespace alpenglow::prt {

// Of everything that changes a result: not of threads, memory and callback.
[[nodiscard]] std::uint64_t settings_hash(const BakeSettings& settings);
[[nodiscard]] Status check(const BakeSettings& settings);

} // namespace alpenglow::prt
