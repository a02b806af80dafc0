// Receivers: which probes light them, and the light itself.
#pragma once

#include <alpenglow/components/environment_map.hpp>
#include <alpenglow/components/probe_grid.hpp>
#include <alpenglow/components/probe_receiver.hpp>

#include <cstddef>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::probes {

// All that can light a receiver in a scene. Holds references: for the time of one update.
class LightSources {
public:
    // A source that was never made is left out.
    void add(const ProbeGrid& grid, const ProbeGridSh& light);
    void add(const LightProbe& probe, const LightProbeSh& light);
    void add(const EnvironmentMapSh& light); // the first one counts

private:
    friend class Receiving;
    struct Grid {
        const ProbeGrid* grid;
        const ProbeGridSh* light;
        double cell_m3; // the volume of a cell
    };
    struct Probe {
        const LightProbe* probe;
        const LightProbeSh* light;
    };
    std::vector<Grid> grids_;
    std::vector<Probe> probes_;
    const EnvironmentMapSh* environment_ = nullptr;
};

// Lights receivers: those of a grid are gathered and blended together. `lights` and the receivers' ReceiverSh must stay
// where they are until finish().
class Receiving {
public:
    explicit Receiving(const LightSources& lights);

    // False where the receiver's light stands as it is. Otherwise it is written now or by finish(), its revision one
    // up.
    bool add(const ProbeReceiver& receiver, ReceiverSh& light);
    void finish();

private:
    struct Batch {
        std::vector<glm::vec3> positions;
        std::vector<ReceiverSh*> out;
    };
    void blend_batch(std::size_t grid);

    const LightSources& lights_;
    std::vector<Batch> batches_; // one for each grid
    std::vector<ProbeLine> lines_;
};

} // namespace alpenglow::probes
