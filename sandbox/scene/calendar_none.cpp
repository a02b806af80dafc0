#include "sandbox/scene/calendar.hpp"

namespace alpenglow::sandbox {

Result<double> read_time(std::string_view, std::string_view) {
    return 0.0;
}

std::string show_time(double utc_j2000_s) {
    return std::to_string(static_cast<long long>(utc_j2000_s)) + " s";
}

Date date_of(double utc_j2000_s) {
    return {.seconds = utc_j2000_s};
}

std::optional<double> utc_of(const Date& date) {
    return date.seconds;
}

} // namespace alpenglow::sandbox
