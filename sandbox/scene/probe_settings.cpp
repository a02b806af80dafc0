#include "probe_settings.hpp"

#include <array>
#include <string_view>

#include "reader.hpp"

namespace alpenglow::sandbox {

ProbeSettings read_probe_settings(Reader& section) {
    constexpr std::array<std::string_view, 3> ways{"none", "paper", "exact"}; // as Deringing
    ProbeSettings settings;
    auto way = static_cast<int>(settings.deringing);
    section.name("deringing", ways, way);
    settings.deringing = static_cast<Deringing>(way);
    constexpr std::array<std::string_view, 2> sources{"assembled", "captured"}; // as ProbeSource
    auto source = static_cast<int>(settings.source);
    section.name("source", sources, source);
    settings.source = static_cast<ProbeSource>(source);
    section.boolean("show", settings.show);
    return settings;
}

} // namespace alpenglow::sandbox
