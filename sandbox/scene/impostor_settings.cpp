#include "impostor_settings.hpp"

#include "reader.hpp"

namespace alpenglow::sandbox {

ImpostorSettings read_impostor_settings(Reader& section) {
    ImpostorSettings settings;
    section.number("clouds", 0.0, 1000.0, settings.clouds);
    section.number("field_m", 1000.0, 50000.0, settings.field_m);
    section.number("base_m", -500.0, 12000.0, settings.base_m);
    section.number("size_m", 100.0, 5000.0, settings.size_m);
    section.number("detail", 0.0, 4.0, settings.detail);
    section.number("opacity", 0.01, 100.0, settings.opacity);
    section.number("craft", 0.0, 100.0, settings.craft);
    section.boolean("follow", settings.follow);
    section.number("max_error", 0.0, 1.0, settings.max_error);
    section.number("budget_texels", 0.0, 1e7, settings.budget_texels);
    section.boolean("outlines", settings.outlines);
    section.boolean("direct", settings.direct);
    return settings;
}

} // namespace alpenglow::sandbox
