// What the device needs to march the clouds, packed once and kept while it holds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <alpenglow/clouds/march.hpp>

#include "sandbox/world/cloud_render_data.hpp"

namespace alpenglow::sandbox {

// A cloud of the picture, with the fields contracted for its eye. Equal revisions: equal content.
struct MarchedCloud {
    clouds::LitCloud cloud;
    const clouds::CloudLighting::ViewFields* fields = nullptr;
    std::uint32_t light_revision = 0;
    std::uint32_t fields_revision = 0;
};

class CloudTables {
public:
    // Volumes stay what they are. `settings.detail` must be the same in every call.
    void update(std::span<const MarchedCloud> clouds, const clouds::Camera& camera,
                const clouds::MarchSettings& settings);
    [[nodiscard]] const CloudMarch& march() const { return march_; }
    [[nodiscard]] std::size_t bytes() const; // of all tables

private:
    struct Kept {
        const void* of = nullptr;           // volume, lighting or fields
        std::uint32_t content_revision = 0; // of what they hold
        std::vector<std::uint32_t> words;
        std::uint32_t revision = 0;
        std::uint32_t number = 0; // in march_.tables
        bool used = false;
    };
    template <class Pack>
    Kept& keep(const void* of, std::uint32_t content_revision, Pack pack);

    std::vector<Kept> kept_;
    std::vector<std::uint32_t> detail_;
    std::uint32_t detail_revision_ = 0;
    CloudMarch march_;
};

} // namespace alpenglow::sandbox
