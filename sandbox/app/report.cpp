#include "sandbox/app/report.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace alpenglow::sandbox {
namespace {

using Json = nlohmann::ordered_json;

double median(std::vector<double> values) {
    if (values.empty()) {
        return 0.0;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

Json to_json(const SystemReport& report) {
    Json json{{"considered", report.considered},
              {"updated", report.updated},
              {"skipped", report.skipped},
              {"cpu_ms", report.cpu_ms},
              {"error_bound", report.error_bound}};
    if (report.tables_rebuilt + report.tables_kept > 0) {
        json["tables_rebuilt"] = report.tables_rebuilt;
        json["tables_kept"] = report.tables_kept;
    }
    return json;
}

// The median of one figure of one system over the frames in which it ran.
template <class Figure>
double median_of(const RunReport& run, std::string_view system, Figure figure) {
    std::vector<double> values;
    for (const FrameReport& frame : run.frames) {
        for (const SystemReport& report : frame.systems) {
            if (system == report.system) {
                values.push_back(static_cast<double>(figure(report)));
            }
        }
    }
    return median(std::move(values));
}

} // namespace

std::string to_json(const RunReport& run) {
    Json document{
        {"scene", run.scene}, {"device", run.device}, {"quality", run.quality}, {"size", {run.width, run.height}}};
    Json systems = Json::object();
    std::vector<double> cpu;
    std::vector<double> wall;
    Json frames = Json::array();
    std::vector<double> direct_cpu, direct_wall, compared_cpu, compared_wall, psnr, steps;
    for (const FrameReport& frame : run.frames) {
        cpu.push_back(frame.cpu_ms);
        wall.push_back(frame.wall_ms);
        Json entry{{"index", frames.size()}, {"cpu_ms", frame.cpu_ms}, {"wall_ms", frame.wall_ms}};
        if (frame.direct_cpu_ms > 0.0) {
            entry["direct_cpu_ms"] = frame.direct_cpu_ms;
            entry["direct_wall_ms"] = frame.direct_wall_ms;
            direct_cpu.push_back(frame.direct_cpu_ms);
            direct_wall.push_back(frame.direct_wall_ms);
            compared_cpu.push_back(frame.cpu_ms);
            compared_wall.push_back(frame.wall_ms);
        }
        for (const SystemReport& report : frame.systems) {
            const std::string_view system = report.system;
            if (system == "compare") {
                psnr.push_back(report.error_bound);
            } else if (system == "compare_steps") {
                steps.push_back(report.error_bound);
            }
            entry["systems"][report.system] = to_json(report);
            systems[report.system] = nullptr;
        }
        frames.push_back(std::move(entry));
    }
    for (auto& [name, entry] : systems.items()) {
        entry = {{"considered", median_of(run, name, [](const SystemReport& r) { return r.considered; })},
                 {"updated", median_of(run, name, [](const SystemReport& r) { return r.updated; })},
                 {"skipped", median_of(run, name, [](const SystemReport& r) { return r.skipped; })},
                 {"cpu_ms", median_of(run, name, [](const SystemReport& r) { return r.cpu_ms; })},
                 {"error_bound", median_of(run, name, [](const SystemReport& r) { return r.error_bound; })}};
    }
    document["medians"] = {{"cpu_ms", median(cpu)}, {"wall_ms", median(wall)}, {"systems", std::move(systems)}};
    if (!psnr.empty()) { // the same frames both ways
        Json compared{{"frames", psnr.size()},
                      {"psnr_least_db", *std::min_element(psnr.begin(), psnr.end())},
                      {"psnr_median_db", median(psnr)},
                      {"cpu_ms", median(compared_cpu)},
                      {"wall_ms", median(compared_wall)},
                      {"direct_cpu_ms", median(direct_cpu)},
                      {"direct_wall_ms", median(direct_wall)},
                      {"cpu_ratio", median(direct_cpu) / std::max(median(compared_cpu), 1e-9)},
                      {"wall_ratio", median(direct_wall) / std::max(median(compared_wall), 1e-9)}};
        if (!steps.empty()) {
            compared["step_median"] = median(steps);
            compared["step_largest"] = *std::max_element(steps.begin(), steps.end());
        }
        document["compared"] = std::move(compared);
    }
    document["frames"] = std::move(frames);
    return document.dump(1) + "\n";
}

Status write_file(const std::string& path, const std::string& bytes) {
    const std::string temporary = path + ".tmp";
    const auto fail = [&](const char* what) {
        const Error error{std::string(what) + ": " + std::strerror(errno), path, "a path that can be written"};
        std::error_code ignored;
        std::filesystem::remove(temporary, ignored);
        return error;
    };
    {
        std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
        if (!file) {
            return fail("cannot be written");
        }
        file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        if (!file.flush()) {
            return fail("cannot be written whole");
        }
    }
    if (std::rename(temporary.c_str(), path.c_str()) != 0) {
        return fail("cannot be put in place");
    }
    return Ok{};
}

} // namespace alpenglow::sandbox
