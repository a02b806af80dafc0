// Bakes in the background, kept in files by the hash of all that they depend on.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <alpenglow/core/result.hpp>
#include <alpenglow/prt/bake.hpp>
#include <alpenglow/prt/bake_glossy.hpp>
#include <alpenglow/prt/bake_neighbourhood.hpp>
#include <alpenglow/prt/bake_volume.hpp>
#include <alpenglow/prt/transfer_table.hpp>

namespace alpenglow::sandbox {

// One thing's tables by TransferLevel, half floats; null where a level has none.
using TransferTables = std::array<std::shared_ptr<const prt::TransferTable>, 3>;

struct BakeJob {
    std::string name;      // for people
    std::uint64_t key = 0; // of everything that the tables depend on
    std::function<Result<TransferTables>(const prt::ProgressCallback&)> bake;
    std::size_t first_level = 0; // the lowest that has a table
};

// Vectors for a mesh; shadowed and interreflected share their rays.
[[nodiscard]] BakeJob diffuse_job(std::string name, prt::Mesh mesh, prt::BakeSettings settings);
// Matrices for a mesh, at the three levels.
[[nodiscard]] BakeJob glossy_job(std::string name, prt::Mesh mesh, prt::GlossySettings settings);
// Around a mesh: none unshadowed, then without and with what bounces off it.
[[nodiscard]] BakeJob neighbourhood_job(std::string name, prt::Mesh mesh, const prt::Grid& grid,
                                        prt::NeighbourhoodSettings settings);
// Smoke: light as if it were not there, attenuated, scattered many times.
[[nodiscard]] BakeJob volume_job(std::string name, prt::VolumeDensity density, prt::VolumeSettings settings);

// What a mesh without any bake shows: the cosine alone.
[[nodiscard]] Result<prt::TransferTable> unshadowed_table(const prt::Mesh& mesh, int order);

// $XDG_CACHE_HOME/alpenglow or ~/.cache/alpenglow; empty where the environment names neither.
[[nodiscard]] std::filesystem::path cache_folder();

// Does the jobs one after the other on a thread of its own.
class TransferBakes {
public:
    // `cache`: a folder, made where it is missing. Empty or not writable: everything is baked anew.
    TransferBakes(std::vector<BakeJob> jobs, std::filesystem::path cache);
    ~TransferBakes(); // cancels
    TransferBakes(const TransferBakes&) = delete;
    TransferBakes& operator=(const TransferBakes&) = delete;

    struct State {
        std::size_t done = 0; // jobs
        std::size_t from_cache = 0;
        std::size_t failed = 0;
        double fraction = 0.0; // of the job under way
        std::string job;       // its name; empty when all are done
        std::string problem;   // the first one
    };
    [[nodiscard]] State state() const;
    [[nodiscard]] std::size_t count() const { return jobs_.size(); }
    // Tables of a job once it is done; all null where it failed.
    [[nodiscard]] bool take(std::size_t job, TransferTables& tables) const;
    // Blocks until all are done.
    void wait();

private:
    void run();
    [[nodiscard]] std::filesystem::path file(const BakeJob& job, std::size_t level) const;
    [[nodiscard]] bool load(const BakeJob& job, TransferTables& tables) const;
    void keep(const BakeJob& job, const TransferTables& tables);

    const std::vector<BakeJob> jobs_;
    std::filesystem::path cache_;
    std::atomic<bool> cancel_{false};
    mutable std::mutex mutex_;
    State state_;
    std::vector<TransferTables> tables_;
    std::thread thread_; // last: it works on the rest
};

} // namespace alpenglow::sandbox
