"""Physical values by canonical name: named sets, parameter files, corrected plants."""
