#include "read_vdb.hpp"

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#endif
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

namespace alpenglow::bake {

Result<prt::VolumeDensity> read_vdb(const std::filesystem::path& path, unsigned size, float extinction_scale) {
    try {
        openvdb::initialize();
        openvdb::io::File file(path.string());
        file.open();
        openvdb::FloatGrid::Ptr grid;
        for (auto name = file.beginName(); name != file.endName(); ++name) {
            const auto meta = file.readGridMetadata(name.gridName());
            if (!meta->isType<openvdb::FloatGrid>()) {
                continue;
            }
            if (grid == nullptr || name.gridName() == "density") {
                grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid(name.gridName()));
            }
        }
        if (grid == nullptr) {
            return Error{"holds no float grid", path.string(), "a grid of density"};
        }
        const openvdb::CoordBBox active = grid->evalActiveVoxelBoundingBox();
        if (active.empty()) {
            return Error{"its grid is empty", path.string(), "active voxels"};
        }
        openvdb::BBoxd world;
        for (int corner = 0; corner < 8; ++corner) {
            world.expand(
                grid->indexToWorld(openvdb::Vec3d((corner & 1) != 0 ? active.max().x() + 1 : active.min().x() - 1,
                                                  (corner & 2) != 0 ? active.max().y() + 1 : active.min().y() - 1,
                                                  (corner & 4) != 0 ? active.max().z() + 1 : active.min().z() - 1)));
        }
        const openvdb::Vec3d extent = world.extents();
        const double longest = std::max({extent.x(), extent.y(), extent.z()});
        prt::VolumeDensity density;
        const double step = longest / std::max(1U, size - 1);
        density.grid.step_m = glm::vec3(static_cast<float>(step));
        density.grid.origin_m = glm::vec3(glm::dvec3(world.min().x(), world.min().y(), world.min().z()));
        density.grid.size = glm::uvec3(glm::ceil(glm::dvec3(extent.x(), extent.y(), extent.z()) / step - 1e-6)) + 1U;
        openvdb::tools::GridSampler<openvdb::FloatGrid, openvdb::tools::BoxSampler> sampler(*grid);
        for (unsigned z = 0; z < density.grid.size.z; ++z) {
            for (unsigned y = 0; y < density.grid.size.y; ++y) {
                for (unsigned x = 0; x < density.grid.size.x; ++x) {
                    const float value = sampler.wsSample(world.min() + step * openvdb::Vec3d(x, y, z));
                    density.extinction_per_m.push_back(std::max(0.0F, value) * extinction_scale);
                }
            }
        }
        return density;
    } catch (const std::exception& failure) {
        return Error{std::string("cannot be read: ") + failure.what(), path.string(), "an OpenVDB file"};
    }
}

} // namespace alpenglow::bake
