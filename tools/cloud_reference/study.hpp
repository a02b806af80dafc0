// The study behind docs/clouds.md: every lighting method against the path tracer over media and views.
#pragma once

#include <string>
#include <vector>

#include <alpenglow/core/result.hpp>

namespace alpenglow::tool {

struct StudyOptions {
    std::string folder; // of the references: read where they exist, made where not
    int samples = 1024; // a pixel, of references
    unsigned cloud = 1; // seed of clouds::cumulus_of_study; from 100 on of clouds::noise_cloud
    std::vector<std::string> methods{"single", "harris", "octaves", "transport"};
    std::vector<double> albedos{0.9, 0.99, 1.0};
    std::vector<double> anisotropies{0.0, 0.85, 0.95};
    int transport_factor = 0; // 0: the default, by the size of the cloud
    int sweeps = 0;           // 0: the default
    bool references_only = false;
};

// Prints a table in Markdown: relative RMSE and bias by medium, view and method, and the CPU time of the bakes.
[[nodiscard]] Status run_study(const StudyOptions& options);

} // namespace alpenglow::tool
