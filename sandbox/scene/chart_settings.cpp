#include "chart_settings.hpp"

#include "reader.hpp"

namespace alpenglow::sandbox {

ChartSettings read_chart_settings(Reader& section) {
    ChartSettings settings;
    auto show = static_cast<int>(settings.show);
    section.name("show", chart_names, show);
    settings.show = static_cast<Chart>(show);
    section.number("bands", 1, 7, settings.bands);
    auto filter = static_cast<int>(settings.filter);
    section.name("filter", chart_filter_names, filter);
    settings.filter = static_cast<ChartFilter>(filter);
    return settings;
}

} // namespace alpenglow::sandbox
