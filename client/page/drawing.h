/// What the picture of a robot is made of.
#pragma once

#include "page/columns.h"

namespace torqued
{

/// Links with their strokes, joints, feet, and what the picture is scaled by.
Json drawing_of(const Robot& robot);

} // namespace torqued
