// Checks of images that the vectorised and the reference projection share.
#pragma once

#include <alpenglow/sh/image.hpp>

#include <optional>

namespace alpenglow::sh::detail {

[[nodiscard]] std::optional<Error> check(const CubeMap& map, int supersampling);
[[nodiscard]] std::optional<Error> check(const EquirectMap& map, int supersampling);

} // namespace alpenglow::sh::detail
