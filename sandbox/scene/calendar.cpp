#include "sandbox/scene/calendar.hpp"

#include <alpenglow/ephemeris/time.hpp>

namespace alpenglow::sandbox {

Result<double> read_time(std::string_view text, std::string_view where) {
    return ephemeris::parse_time(text, where);
}

std::string show_time(double utc_j2000_s) {
    return ephemeris::format_time(utc_j2000_s);
}

Date date_of(double utc_j2000_s) {
    const ephemeris::CalendarTime time = ephemeris::calendar_from_utc(utc_j2000_s);
    return {time.year, time.month, time.day, time.hour * 3600.0 + time.minute * 60.0 + time.second};
}

std::optional<double> utc_of(const Date& date) {
    ephemeris::CalendarTime midnight;
    midnight.year = date.year;
    midnight.month = date.month;
    midnight.day = date.day;
    const Result<double> utc = ephemeris::utc_from_calendar(midnight);
    return utc ? std::optional(*utc + date.seconds) : std::nullopt;
}

} // namespace alpenglow::sandbox
