// The section `atmosphere` of a scene.
#pragma once

#include <array>
#include <string_view>

#include <alpenglow/components/sky.hpp>

namespace alpenglow::sandbox {

class Reader;

// As SkyModel.
inline constexpr std::array<std::string_view, 7> sky_model_names{"preetham", "perez",       "cie-clear", "cie-overcast",
                                                                 "asrc-cie", "cie-general", "scattering"};

// Parameters that the model does not read are refused: they would change nothing.
[[nodiscard]] Atmosphere read_atmosphere_settings(Reader& section);

} // namespace alpenglow::sandbox
