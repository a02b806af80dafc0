// Discrete ordinates on a coarse lattice: the multiply scattered part of the light. Internal to the module.
//
// 64 directions (4 Gauss in the polar cosine, 16 in azimuth), diamond differences with a fix-up against negative
// radiance (Lewis & Miller 1984, ch. 4), phase function by its moments up to l = 3 after delta-M scaling; a P1
// (diffusion) solution to start from and a P1 correction of scalar flux and current after each sweep (Alcouffe 1977),
// by conjugate gradients with a multigrid V-cycle before them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <glm/vec3.hpp>

#include <alpenglow/clouds/beam.hpp>
#include <alpenglow/clouds/optical_depth.hpp>

namespace alpenglow::clouds {

inline constexpr int ordinates = 64;
inline constexpr int ordinate_moments = 16;

// Direction (unit, grid frame) and weight (sum 4 pi) of ordinate i; ordinates 8 o .. 8 o + 7 share octant o, whose bits
// 0, 1, 2 say that x, y, z are negative.
struct Ordinate {
    glm::vec3 direction;
    float weight;
};
[[nodiscard]] const Ordinate* ordinate_table();

// Moments of radiance, integral of I Y_lm over the sphere, for each cell near the cloud.
using RadianceMoments = std::vector<float>; // 16 a active cell

class Transport {
public:
    // `density`: block means on the lattice.
    Transport(const Lattice& lattice, const std::vector<float>& density, const glm::vec3& block_m,
              const Medium& medium);

    [[nodiscard]] const Lattice& lattice() const { return lattice_; }
    [[nodiscard]] const ScaledMedium& scaled() const { return scaled_; }
    [[nodiscard]] const std::vector<std::int32_t>& active() const { return active_; } // of each cell: its number, or -1
    [[nodiscard]] std::size_t active_count() const { return active_count_; }
    [[nodiscard]] const std::vector<float>& extinction() const { return sigma_; } // scaled, 1/m
    [[nodiscard]] std::size_t memory_bytes() const;

    // One level of the diffusion operator: per cell conductances to the next cell in x, y, z, 1 / diagonal.
    struct Level {
        glm::ivec3 dims;
        std::size_t pad = 0; // zeros before and after each array, so that neighbours can be read without a test
        std::vector<float> gx, gy, gz, absorption, inverse_diagonal;
    };

private:
    friend class TransportJob;
    // A V-cycle's vectors, one set a level: each job has its own.
    struct Scratch {
        std::vector<std::vector<float>> x, b, r;
    };
    [[nodiscard]] Scratch make_scratch() const;
    void make_levels();
    void p1_solve(Scratch& scratch, const std::vector<float>& rhs, std::vector<float>& x, int iterations,
                  float tolerance) const;
    void v_cycle(Scratch& scratch, std::size_t level) const;
    // P1 solution for isotropic and current sources (dense), added to `moments`. start: from the isotropic inflow.
    void p1_correct(Scratch& scratch, const std::vector<float>& source0, const std::vector<glm::vec3>& source1,
                    bool start, float inflow, RadianceMoments& moments) const;

    Lattice lattice_;
    glm::vec3 block_m_;
    ScaledMedium scaled_;
    std::vector<float> sigma_; // scaled extinction
    std::vector<std::int32_t> active_;
    std::vector<std::int32_t> cell_of_; // of each active number
    std::size_t active_count_ = 0;
    std::vector<float> transport_; // transport extinction with a floor in empty cells
    std::vector<float> boundary_;  // conductance to the outside
    std::vector<Level> levels_;
};

// One solution in the making. Slices of work are bounded (one octant's sweep at most), so that a bake can be spread
// over frames; sliced or not, the bits are the same.
class TransportJob {
public:
    struct Source {
        std::vector<float>
            deposit; // irradiance that the beam loses in each cell, 1/m a unit irradiance; empty: no beam
        glm::vec3 to_light{0, 0, 1};           // grid frame
        std::array<float, ordinates> inflow{}; // radiance that enters along each ordinate
    };

    // Iterates `sweeps` times from `start` if it has the right size (a warm start), else from a P1 solution.
    // `transport` must outlive the job.
    TransportJob(const Transport& transport, Source source, int sweeps, RadianceMoments start);
    ~TransportJob();
    TransportJob(TransportJob&&) noexcept;
    TransportJob& operator=(TransportJob&&) noexcept;

    [[nodiscard]] bool done() const;
    void advance(); // one slice
    void run();     // to the end, two octants at a time
    [[nodiscard]] const RadianceMoments& moments() const;
    [[nodiscard]] float change() const; // relative, of the scalar flux in the last sweep

private:
    struct State;
    void begin_sweep();
    void end_sweep();
    std::unique_ptr<State> state_;
};

} // namespace alpenglow::clouds
