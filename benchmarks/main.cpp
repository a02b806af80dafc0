// alpenglow-bench: run time against error for every module.
#include "bench.hpp"

#include <alpenglow/core/timing.hpp>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <regex>
#include <utility>

namespace alpenglow::bench {
namespace {

using Registered = std::pair<std::string, std::function<void(const Context&)>>;

std::vector<Registered>& registry() {
    static std::vector<Registered> cases;
    return cases;
}

nlohmann::ordered_json to_json(const Row& row) {
    return {{"module", row.module},
            {"case", row.name},
            {"method", row.method},
            {"time_ns", row.time_ns},
            {"time_spread", row.time_spread},
            {"error", row.error},
            {"error_metric", row.error_metric},
            {"reference", row.reference},
            {"bytes", row.bytes},
            {"items", row.items}};
}

} // namespace

Case::Case(std::string name, std::function<void(const Context&)> body) {
    registry().emplace_back(std::move(name), std::move(body));
}

Time Context::time(double items, const std::function<void()>& call) const {
    const double slice_s = quick_ ? 2e-3 : 2e-2;
    const int repetitions = quick_ ? 5 : 15;
    // Warm up, and find how many calls make a slice long enough for the clock.
    std::size_t calls = 1;
    for (;;) {
        const double start = thread_cpu_seconds();
        for (std::size_t i = 0; i < calls; ++i) {
            call();
        }
        const double took = thread_cpu_seconds() - start;
        if (took >= slice_s) {
            break;
        }
        calls = took < slice_s / 16.0 ? calls * 8 : calls * 2;
    }
    std::vector<double> ns;
    for (int r = 0; r < repetitions; ++r) {
        const double start = thread_cpu_seconds();
        for (std::size_t i = 0; i < calls; ++i) {
            call();
        }
        ns.push_back((thread_cpu_seconds() - start) * 1e9 / (static_cast<double>(calls) * items));
    }
    std::sort(ns.begin(), ns.end());
    const std::size_t n = ns.size();
    return {ns[n / 2], (ns[3 * n / 4] - ns[n / 4]) / ns[n / 2]};
}

} // namespace alpenglow::bench

int main(int argc, char** argv) {
    using namespace alpenglow::bench;
    CLI::App app{"Run time against error for every Alpenglow module; times are CPU time per item"};
    std::string filter = ".*";
    std::string json_path;
    bool quick = false;
    bool list = false;
    app.add_option("--filter", filter, "Run the cases whose name matches this regular expression");
    app.add_flag("--quick", quick, "Fewer repetitions and smaller domains: a smoke test, not a measurement");
    app.add_option("--json", json_path, "Write the rows to this file");
    app.add_flag("--list", list, "List the cases and exit");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        const int code = app.exit(error);
        return code == 0 ? 0 : 2;
    }
    std::regex pattern;
    try {
        pattern = std::regex(filter);
    } catch (const std::regex_error&) {
        std::cerr << "alpenglow-bench: --filter: '" << filter << "' is no regular expression\n";
        return 2;
    }

    std::sort(registry().begin(), registry().end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<Row> rows;
    bool matched = false;
    for (const auto& [name, body] : registry()) {
        if (!std::regex_search(name, pattern)) {
            continue;
        }
        matched = true;
        if (list) {
            std::cout << name << '\n';
            continue;
        }
        const std::size_t before = rows.size();
        std::cerr << "running " << name << "...\n";
        body(Context{quick, rows});
        for (std::size_t i = before; i < rows.size(); ++i) {
            const Row& row = rows[i];
            std::printf("%-10s %-44s %-34s %12.4g ns  +-%4.1f%%  error %10.3g  %s\n", row.module.c_str(),
                        row.name.c_str(), row.method.c_str(), row.time_ns, 100.0 * row.time_spread, row.error,
                        row.error_metric.c_str());
        }
        std::fflush(stdout);
    }
    if (!matched) {
        std::cerr << "alpenglow-bench: no case matches '" << filter << "'; --list shows them\n";
        return 2;
    }
    if (!json_path.empty()) {
        nlohmann::ordered_json document = nlohmann::ordered_json::array();
        for (const Row& row : rows) {
            document.push_back(to_json(row));
        }
        std::ofstream file(json_path);
        file << document.dump(1) << '\n';
        if (!file.flush()) {
            std::cerr << "alpenglow-bench: --json: cannot write '" << json_path << "'\n";
            return 2;
        }
    }
    return 0;
}
